"""What the graph is: node labels, edge types, their properties and units, as data, once.

Everything else that must agree with the graph is made from these tables: the SQLite tables, the Neo4j
constraints and indexes, the checks of a graph file, the names a question may use, the reference page.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final

SCHEMA_VERSION: Final = 2
"""Version of the stored graph; a store of another version is refused or migrated, never guessed at."""


class Kind(Enum):
    """What a property holds, in memory and in a graph file."""

    TEXT = "text"
    INTEGER = "integer"
    REAL = "number"
    TEXTS = "list of texts"
    INTEGERS = "list of integers"
    REALS = "list of numbers"
    RINGS = "list of rings"  # each ring a flat list x0 y0 x1 y1 ...; the first is the outer one
    MAPPING = "mapping"
    DESCRIPTOR = "descriptor"

    @property
    def scalar(self) -> bool:
        """Whether a question may compare the property with a value."""
        return self in (Kind.TEXT, Kind.INTEGER, Kind.REAL)

    @property
    def numeric(self) -> bool:
        """Whether the property is a number."""
        return self in (Kind.INTEGER, Kind.REAL)


@dataclass(frozen=True, slots=True)
class Property:
    """One property of a node label or an edge type.

    Attributes
    ----------
    name
        As spelled in graph, language and files.
    kind
        What it holds.
    text
        One line for the reference page.
    unit
        SI unit, or empty.
    indexed
        Whether the stores keep an index on it.
    values
        The only texts allowed, if the property is an enumeration.
    length
        Number of elements, if a list has always as many; else 0.
    """

    name: str
    kind: Kind
    text: str
    unit: str = ""
    indexed: bool = False
    values: tuple[str, ...] = ()
    length: int = 0


@dataclass(frozen=True, slots=True)
class NodeType:
    """A node label, its key pattern and its properties (without ``id``, ``building``, ``name``)."""

    label: str
    key: str
    text: str
    properties: tuple[Property, ...]

    def property(self, name: str) -> Property | None:
        """Return the property of that name, common ones included, or None."""
        return next((p for p in (*COMMON, *self.properties) if p.name == name), None)


@dataclass(frozen=True, slots=True)
class EdgeType:
    """An edge type: what it joins and its properties.

    `ends` lists the (source label, target label) pairs; an undirected edge is stored once.
    """

    type: str
    ends: tuple[tuple[str, str], ...]
    text: str
    directed: bool = True
    properties: tuple[Property, ...] = ()

    def property(self, name: str) -> Property | None:
        """Return the property of that name, or None."""
        return next((p for p in self.properties if p.name == name), None)


COMMON: Final = (
    Property("id", Kind.TEXT, "the key, unique in the store", indexed=True),
    Property("building", Kind.TEXT, "id of the building that the node belongs to", indexed=True),
    Property("name", Kind.TEXT, "short readable name", indexed=True),
)
"""Properties that every node carries."""

DOORLIKE_KINDS: Final = ("door", "passage", "stairs", "hatch", "window")
"""Kinds of opening; each is an edge between two rooms in a question (``DOOR``, ``PASSAGE``, ...)."""

NODE_TYPES: Final = (
    NodeType(
        "Building",
        "ID",
        "one registered set of scans",
        (
            Property("source_files", Kind.TEXTS, "names of the scan files"),
            Property("scan_count", Kind.INTEGER, "scans read"),
            Property("point_count", Kind.INTEGER, "points read, before thinning"),
            Property("bounds", Kind.REALS, "xmin ymin zmin xmax ymax zmax", "m", length=6),
            Property(
                "origin",
                Kind.REALS,
                "offset taken off while computing; coordinates in the graph have it",
                "m",
                length=3,
            ),
            Property("ingested_at", Kind.TEXT, "time of ingest, ISO 8601, UTC"),
            Property("parameters", Kind.MAPPING, "the resolved parameters of every stage"),
            Property("software_version", Kind.TEXT, "version of Enfilade that wrote the graph"),
            Property("content_hash", Kind.TEXT, "hash of the scan files and the parameters"),
            Property("cloud", Kind.TEXT, "file name of its labelled cloud in the clouds folder"),
        ),
    ),
    NodeType(
        "Storey",
        "ID/s0",
        "rooms whose floors lie at one level",
        (
            Property("index", Kind.INTEGER, "0 is the lowest", indexed=True),
            Property("elevation", Kind.REAL, "level of the floors", "m"),
            Property("height", Kind.REAL, "from this floor to the highest ceiling of the storey", "m"),
            Property("area", Kind.REAL, "sum of the areas of the rooms", "m²"),
        ),
    ),
    NodeType(
        "Room",
        "ID/r12",
        "space bounded by walls, floor and ceiling",
        (
            Property("area", Kind.REAL, "floor area up to the walls under the ceiling", "m²", True),
            Property("floor_elevation", Kind.REAL, "mean height of the floor plane's points (Eq. 7)", "m"),
            Property("ceiling_elevation", Kind.REAL, "height of the ceiling", "m"),
            Property("height", Kind.REAL, "from floor to ceiling", "m"),
            Property("centroid", Kind.REALS, "centre of the floor area: x y z", "m", length=3),
            Property("bounds", Kind.REALS, "xmin ymin zmin xmax ymax zmax", "m", length=6),
            Property("outline", Kind.RINGS, "simplified plan polygon, rings as flat lists, outer ring first", "m"),
            Property("point_count", Kind.INTEGER, "thinned points in the room"),
            Property("scans", Kind.TEXTS, "names of the scans that stand in the room"),
            Property("scan_positions", Kind.REALS, "where these scanners stood, in the same order: x y z each", "m"),
            Property(
                "seen_from",
                Kind.TEXT,
                "`inside`, or `outside` where no scan stands in the room and scanners looked into it",
                indexed=True,
            ),
            Property("function", Kind.TEXT, "kitchen, office, ...; absent until something says it", indexed=True),
            Property("confidence", Kind.REAL, "share of the labels that the room's points agree on, 0 to 1"),
        ),
    ),
    NodeType(
        "Opening",
        "ID/p7",
        "door, passage, window, stairs or hatch, between two rooms or to the outside",
        (
            Property("kind", Kind.TEXT, "what it is; a passage has no lintel", "", True, DOORLIKE_KINDS),
            Property("orientation", Kind.TEXT, "the paper's two edge kinds", "", False, ("horizontal", "vertical")),
            Property("width", Kind.REAL, "clear width", "m"),
            Property("height", Kind.REAL, "clear height", "m"),
            Property("sill", Kind.REAL, "height of its lower edge over the floor", "m"),
            Property("lintel", Kind.REAL, "height of the wall over it, 0 for a passage", "m"),
            Property("area", Kind.REAL, "of the hole", "m²"),
            Property("position", Kind.REALS, "centre of the hole: x y z", "m", length=3),
            Property("normal", Kind.REALS, "unit vector across the opening", length=3),
            Property("ray_count", Kind.INTEGER, "laser rays that went through"),
            Property("state", Kind.TEXT, "how its leaf was seen", "", False, ("open", "ajar", "closed")),
            Property("confidence", Kind.REAL, "how sure it is that the opening is there, 0 to 1"),
        ),
    ),
    NodeType(
        "Object",
        "ID/o31, ID/o31+o32",
        "furniture or fixture, or a combination of up to three nearby segments",
        (
            Property("segments", Kind.TEXTS, "ids of the one to three segments"),
            Property("parts", Kind.INTEGER, "number of segments", "", True),
            Property("size", Kind.REALS, "extent along x y z", "m", length=3),
            Property("position", Kind.REALS, "mean of its points: x y z", "m", length=3),
            Property("floor_offset", Kind.REAL, "height of its foot over the room's floor", "m"),
            Property("point_count", Kind.INTEGER, "thinned points"),
            Property("descriptor", Kind.DESCRIPTOR, "shape, base at the room's floor (Eqs. 8-10)"),
            Property("foot_descriptor", Kind.DESCRIPTOR, "the same with its base at the object's own foot"),
        ),
    ),
)

EDGE_TYPES: Final = (
    EdgeType("HAS_STOREY", (("Building", "Storey"),), "a building's storeys"),
    EdgeType("BELOW", (("Storey", "Storey"),), "from a storey to the next higher one"),
    EdgeType("HAS_ROOM", (("Storey", "Room"),), "a storey's rooms"),
    EdgeType("CONTAINS", (("Room", "Object"),), "what stands or hangs in a room"),
    EdgeType(
        "NEIGHBOUR",
        (("Room", "Room"),),
        "two rooms that share a wall, floor or ceiling (§5.1); at most one a pair",
        directed=False,
        properties=(
            Property("gap", Kind.REAL, "thickness of what is between them", "m"),
            Property("area", Kind.REAL, "shared area", "m²"),
            Property("planes", Kind.INTEGERS, "numbers of the planes that face each other"),
        ),
    ),
    EdgeType("OPENS", (("Room", "Opening"),), "from each room that an opening leads to"),
    EdgeType(
        "NEAR",
        (("Object", "Object"),),
        "two segments of a room that lie close together",
        directed=False,
        properties=(Property("distance", Kind.REAL, "least distance of their points", "m"),),
    ),
    EdgeType("PART_OF", (("Object", "Object"),), "from a segment to a combination that holds it"),
)

NODES: Final = {node.label: node for node in NODE_TYPES}
EDGES: Final = {edge.type: edge for edge in EDGE_TYPES}

NODE_PROPERTIES: Final = {label: {p.name: p for p in (*COMMON, *node.properties)} for label, node in NODES.items()}
"""Properties by label and name, the common ones included, in their order."""

EDGE_PROPERTIES: Final = {type: {p.name: p for p in edge.properties} for type, edge in EDGES.items()}
"""Properties by edge type and name, in their order."""
