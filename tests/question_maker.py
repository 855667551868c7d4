"""Random buildings and random questions about them, drawn from the whole grammar by a seeded generator."""

from __future__ import annotations

import random
from itertools import combinations

import numpy as np

from enfilade.descriptors import quantise
from enfilade.schema.graph import BuildingGraph

SHAPE = (1, 2, 4)
NAMES = ("Hall", "Küche", "hall", "Bad", "𐐷 room", "\uff5e end", "it's")
AGGREGATES = ("count", "avg", "min", "max", "sum", "collect", "stDev", "stDevP", "percentileCont", "percentileDisc")
KINDS = ("door", "door", "door", "passage", "stairs", "hatch", "window")
PROTOTYPES = (
    [4, 2, 0, 0, 2, 0, 0, 0],
    [0, 0, 0, 0, 1, 1, 0, 0],
    [1] * 8,
    [1, 0, 0, 1, 0, 0, 0, 0],
    [3, 1, 0, 0, 2, 2, 0, 0],
)


def random_building(rng: random.Random, name: str) -> BuildingGraph:
    """A small building with parallel doors, rings, missing properties, combinations and like objects."""
    graph = BuildingGraph(name, descriptor_shape=SHAPE)
    graph.add_node(name, "Building", name=name.upper())
    storeys = [f"{name}/s{i}" for i in range(rng.randint(1, 2))]
    for i, storey in enumerate(storeys):
        graph.add_node(storey, "Storey", index=i, elevation=3.0 * i, name=rng.choice((f"S{i}", None)))
        graph.add_edge(name, "HAS_STOREY", storey)
    if len(storeys) > 1:
        graph.add_edge(storeys[0], "BELOW", storeys[1])
    rooms = [f"{name}/r{i}" for i in rng.sample(range(12), rng.randint(2, 5))]
    for room in rooms:
        _add_room(rng, graph, room, rng.randrange(len(storeys)))
    _add_openings(rng, graph, rooms)
    for a, b in combinations(rooms, 2):
        if rng.random() < 0.4:
            graph.add_edge(
                *_turned(rng, a, "NEIGHBOUR", b), gap=rng.choice((0.1, 0.25, None)), area=rng.choice((2.0, 6.0))
            )
    numbers = iter(rng.sample(range(20), 20))
    for room, count in zip(rooms, [1, *(rng.choice((0, 1, 1, 2, 3)) for _ in rooms[1:])], strict=True):
        _add_objects(rng, graph, room, [next(numbers) for _ in range(count)])
    return graph


def _turned(rng: random.Random, a: str, type: str, b: str) -> tuple[str, str, str]:
    return (a, type, b) if rng.random() < 0.5 else (b, type, a)


def _add_room(rng: random.Random, graph: BuildingGraph, room: str, storey: int) -> None:
    graph.add_node(
        room,
        "Room",
        name=rng.choice((*NAMES, None)),
        area=rng.choice((4.0, 9.0, 12.5, 12.5, 20.0, None)),
        height=rng.choice((2.4, 2.5, 3.0, None, None)),
        floor_elevation=rng.choice((3.0 * storey, 3.0 * storey, 3.0 * storey + 0.5, None)),
        point_count=rng.choice((100, 200, None)),
        scans=rng.choice((["a", "b"], ["b"], None)),
    )
    graph.add_edge(f"{graph.building}/s{storey}", "HAS_ROOM", room)


def _add_openings(rng: random.Random, graph: BuildingGraph, rooms: list[str]) -> None:
    pairs = [pair for pair in combinations(rooms, 2) for _ in range(rng.choice((0, 1, 1, 2)))]
    outside = [(room,) for room in rooms if rng.random() < 0.3]
    numbers = rng.sample(range(30), len(pairs) + len(outside))
    for number, ends in zip(numbers, [*pairs, *outside], strict=True):
        kind = rng.choice(KINDS) if len(ends) == 2 else "window"
        opening = f"{graph.building}/p{number}"
        graph.add_node(
            opening,
            "Opening",
            kind=rng.choice((kind, kind, kind, None)),
            width=rng.choice((0.7, 0.8, 0.9, 2.0, None)),
            state=rng.choice(("open", "closed", None)),
        )
        for room in rng.sample(ends, len(ends)):
            graph.add_edge(room, "OPENS", opening)


def _add_objects(rng: random.Random, graph: BuildingGraph, room: str, numbers: list[int]) -> None:
    for size in (1, 2, 3):
        for chosen in combinations(numbers, size):
            if size > 1 and rng.random() < 0.4:
                continue
            object = f"{graph.building}/" + "+".join(f"o{number}" for number in chosen)
            graph.add_node(
                object,
                "Object",
                segments=[f"{graph.building}/o{number}" for number in chosen] if rng.random() < 0.8 else None,
                parts=size if rng.random() < 0.8 else None,
                floor_offset=rng.choice((0.0, 0.8, None)),
                point_count=rng.choice((50, 70)),
                descriptor=_descriptor(rng),
            )
            graph.add_edge(room, "CONTAINS", object)
            for number in chosen if size > 1 else ():
                graph.add_edge(f"{graph.building}/o{number}", "PART_OF", object)
    for a, b in combinations(numbers, 2):
        if rng.random() < 0.6:
            ends = _turned(rng, f"{graph.building}/o{a}", "NEAR", f"{graph.building}/o{b}")
            graph.add_edge(*ends, distance=rng.choice((0.1, 0.3)))


def _descriptor(rng: random.Random) -> np.ndarray | None:
    if rng.random() < 0.15:
        return None
    return quantise(np.roll(np.reshape(rng.choice(PROTOTYPES), (2, 4)), rng.randrange(4), axis=1).ravel())


class QuestionMaker:
    """Writes random questions.

    Parameters
    ----------
    rng
        Where chance comes from.
    objects
        Ids that LIKE may refer to.
    """

    def __init__(self, rng: random.Random, objects: list[str]) -> None:
        self.rng = rng
        self.objects = objects
        self.labels: dict[str, str] = {}
        self.edges: dict[str, str] = {}
        self.inner = 0
        self.likes = 0

    def question(self) -> str:
        """A whole question."""
        self.labels, self.edges, self.likes, self.inner = {}, {}, 0, 0
        rng = self.rng
        if rng.random() < 0.2:
            return self.symmetric()
        if rng.random() < 0.15:
            return self.relaxed()
        text = f"MATCH {self.pattern(rng.choice((1, 2, 2, 3, 3)))}"
        if rng.random() < 0.5:
            text += f" WHERE {self.condition(2)}"
        for _ in range(rng.choice((0, 0, 0, 0, 1, 1, 2))):
            text += f" OPTIONAL MATCH {self.option()}"
        return f"{text} {self.returning()}"

    def symmetric(self) -> str:
        """A question in which two or three rooms play the same part, so that its matches come in sets."""
        rng = self.rng
        names = ["a", "b", "c"][: rng.choice((2, 2, 3))]
        edge = rng.choice(("DOOR", "DOOR", "NEIGHBOUR", "OPENING", "DOOR|NEIGHBOUR"))
        forms = [
            ", ".join(f"(h:Room)-[:{edge}]-({name}:Room)" for name in names),
            ", ".join(f"({name}:Room)" for name in names),
            f"(a:Room)-[:{edge}]-(b:Room), (a)-[:{edge}]-(b)" + ", (c:Room)" * (len(names) == 3),
            f"(a:Room)-[:{edge.split('|')[0]}*1..2]-(b:Room)" + ", (c:Room)" * (len(names) == 3),
        ]
        if len(names) == 3:
            forms.append(f"(a:Room)-[:{edge}]-(b:Room)-[:{edge}]-(c:Room)-[:{edge}]-(a)")
        pattern = rng.choice(forms)
        like = f" {self.likeness()}" if rng.random() < 0.5 else ""
        if rng.random() < 0.5:
            pattern += "".join(f", ({name})-[:CONTAINS]->(o{name}:Object{like})" for name in names)
        said = [
            [f"{name}.area > 4" for name in names],
            [" <> ".join(rng.sample((f"{names[0]}.area", f"{names[1]}.area"), 2))],
            [f"EXISTS {{ ({name})-[:DOOR]-(x:Room) WHERE x.area >= {name}.area }}" for name in names],
            [f"count {{ ({names[0]})-[:DOOR]-({names[1]}) }} < 2"],
            [f"{names[0]}.area + {names[1]}.area >= 16"],
        ]
        conditions = [text for part in rng.sample(said, rng.choice((0, 1, 1, 2))) for text in part]
        rng.shuffle(conditions)
        where = f" WHERE {' AND '.join(conditions)}" if conditions else ""
        if rng.random() < 0.3:
            where += f" OPTIONAL MATCH (z:Room), (q:Room) WHERE z.area {rng.choice('<=')} q.area"
            names += ["z", "q"]
        returned = rng.choice(
            (", ".join(rng.sample(names, len(names))), names[0], "count(*)", "score", "DISTINCT a, b")
        )
        return f"MATCH {pattern}{where} RETURN {returned}"

    def relaxed(self) -> str:
        """A question that takes near misses too: a small one, as the oracle looks at every placement."""
        rng = self.rng
        if rng.random() < 0.3:
            text = self.symmetric()
            while "OPTIONAL" in text or "count(*)" in text or len(text) > 160:
                text = self.symmetric()
            return f"{text} RELAX {rng.choice((1, 1, 2))}"
        text = f"MATCH {self.pattern(rng.choice((1, 1, 2)))}"
        while text.count("-[") > 3:
            self.labels, self.edges, self.likes = {}, {}, 0
            text = f"MATCH {self.pattern(rng.choice((1, 1, 2)))}"
        for word in ("WHERE", "AND")[: rng.choice((0, 1, 1, 2))]:
            text += f" {word} {self.condition(1) if rng.random() < 0.4 else self.comparison()}"
        returning = self.returning()
        while any(f"{word}(" in returning for word in AGGREGATES):
            returning = self.returning()
        return f"{text} {returning} RELAX {rng.choice((1, 1, 2, 3) if text.count('-[') < 3 else (1, 2))}"

    # Patterns

    def new(self, label: str) -> str:
        name = {"Room": "r", "Object": "o", "Storey": "s", "Opening": "w", "Building": "b"}[label] + str(
            len(self.labels)
        )
        self.labels[name] = label
        return name

    def node(self, label: str, *, named: float = 0.85, like: bool = True) -> tuple[str | None, str]:
        """A new node: its name, if it has one, and its text."""
        name = self.new(label) if self.rng.random() < named else None
        parts = [f"{name or ''}:{label}"]
        if self.rng.random() < 0.25:
            parts.append(self.map(label))
        if label == "Object" and like and self.likes < 2 and self.rng.random() < 0.5:
            parts.append(self.likeness())
            self.likes += 1
        return name, f"({' '.join(parts)})"

    def likeness(self) -> str:
        limit = self.rng.choice(("", " WITHIN 0.5", " WITHIN 1", " WITHIN 0.14285714", " WITHIN 0"))
        return f"LIKE object('{self.rng.choice(self.objects)}'){limit}"

    def map(self, label: str) -> str:
        options = {
            "Room": ("area: 9..", "area: ..12.5", "area: 9..20", "name: 'Hall'", "height: 2.5", "height: 2.4..2.5"),
            "Object": ("parts: 1", "parts: 2..3", "floor_offset: 0.8", "point_count: 60..", "parts: 1..2"),
            "Storey": ("index: 0", "index: 0..1", "elevation: 1.."),
            "Opening": ("kind: 'door'", "width: 0.8..", "state: 'open'"),
            "Building": ("name: 'B'",),
        }[label]
        return f"{{{self.rng.choice(options)}}}"

    def pattern(self, rooms: int) -> str:
        rng = self.rng
        kind = rng.random()
        if kind < 0.1:
            name, text = self.node("Object", named=1)
            return text if rng.random() < 0.5 else f"{text}, {self.node('Object', named=1)[1]}"
        parts, names = [], []
        for _ in range(rooms):
            start = rng.choice(names) if names and rng.random() < 0.85 else None
            if start is None:
                name, text = self.node("Room", named=1)
            else:
                name, text = self.node("Room")
                text = (
                    f"({start}){self.room_edge()}{text}" if rng.random() < 0.7 else f"{text}{self.room_edge()}({start})"
                )
            parts.append(text)
            names += [name] if name else []
        if len(names) > 1 and rng.random() < 0.35:
            a, b = rng.sample(names, 2)
            parts.append(f"({a}){self.room_edge()}({b})")
        parts += [self.attachment(rng.choice(names)) for _ in range(rng.choice((0, 0, 1, 1, 2)))]
        return ", ".join(parts)

    def room_edge(self) -> str:
        rng = self.rng
        if rng.random() < 0.12:
            types = rng.choice((":DOOR", ":DOOR|PASSAGE", ":OPENING", ":NEIGHBOUR"))
            return f"-[{types}*{rng.choice(('1..2', '2', '..3', '1..3', '2..3'))}]-"
        if rng.random() < 0.12:
            return rng.choice(("-[:STAIRS]->", "<-[:STAIRS]-", "-[:HATCH|STAIRS]->"))
        types = rng.choice(
            ("DOOR",) * 5
            + ("NEIGHBOUR",) * 2
            + ("PASSAGE", "STAIRS", "OPENING", "DOOR|PASSAGE", "WINDOW", "DOOR|NEIGHBOUR")
        )
        mixed = types == "DOOR|NEIGHBOUR"
        name = ""
        if not mixed and rng.random() < 0.25:
            name = f"e{len(self.labels) + len(self.edges)}"
            if types == "NEIGHBOUR":
                self.edges[name] = types
            else:
                self.labels[name] = "Opening"
        entries = ""
        if rng.random() < 0.2:
            entries = " {gap: 0.1..}" if types == "NEIGHBOUR" else " {area: 3..}" if mixed else " {width: 0.8..}"
        return f"-[{name}:{types}{entries}]-"

    def attachment(self, room: str) -> str:
        rng = self.rng
        choice = rng.random()
        if choice < 0.6:
            text = f"({room})-[:CONTAINS]->{self.node('Object')[1]}"
            if rng.random() < 0.3:
                name = next((n for n, label in self.labels.items() if label == "Object"), None)
                if name is not None:
                    edge = rng.choice(
                        ("-[:PART_OF]->", "-[:PART_OF]-", "-[:NEAR]-", "<-[:PART_OF]-", "-[:NEAR|PART_OF]-")
                    )
                    text += f", ({name}){edge}{self.node('Object', like=False)[1]}"
            return text
        if choice < 0.75:
            return f"{self.node('Storey')[1]}-[:HAS_ROOM]->({room})"
        if choice < 0.85:
            return f"(:Building)-[:HAS_STOREY]->()-[:HAS_ROOM]->({room})"
        return f"({room})-[:OPENS]->{self.node('Opening')[1]}"

    def option(self) -> str:
        rng = self.rng
        rooms = [name for name, label in self.labels.items() if label == "Room"]
        if rooms and rng.random() < 0.85:
            start = rng.choice(rooms)
            if rng.random() < 0.5:
                text = f"({start})-[:CONTAINS]->{self.node('Object')[1]}"
            else:
                text = f"({start}){self.room_edge()}{self.node('Room')[1]}"
        else:
            text = self.node("Room")[1]
        return text + (f" WHERE {self.condition(1)}" if rng.random() < 0.3 else "")

    # Conditions

    def condition(self, depth: int) -> str:
        rng = self.rng
        if depth and rng.random() < 0.55:
            form = rng.choice(("AND", "AND", "OR", "XOR", "NOT"))
            if form == "NOT":
                return f"NOT ({self.condition(depth - 1)})"
            return f"({self.condition(depth - 1)} {form} {self.condition(depth - 1)})"
        if rng.random() < 0.3:
            return self.subquery(depth)
        return self.comparison()

    def comparison(self) -> str:
        rng = self.rng
        number, other = self.number(), self.number()
        sign = rng.choice(("=", "<>", "<", "<=", ">", ">="))
        forms = [
            f"{number} {sign} {rng.choice((2.5, 9, 12.5, 60, 0.8))}",
            f"{number} {sign} {other}",
            f"{number} + {other} {sign} {rng.choice((5, 25))}",
            f"{number} * 2 {sign} {other} - 1",
            f"{number} / 2 {sign} 6",
            f"{number} % 3 = 0",
            f"{number} IS NULL",
            f"{number} IS NOT NULL",
            f"{number} IN [9, 12.5, 2.5, null]",
            f"{number} IN [50, 100, 4]",
            f"2 < {number} <= 12.5",
        ]
        text = self.text()
        if text:
            forms += [f"{text} {sign} 'Hall'", f"{text} STARTS WITH '{rng.choice(('H', 'h', '', 'b'))}'"]
            forms += [
                f"{text} CONTAINS '{rng.choice(('l', 'r0', '+', ''))}'",
                f"{text} ENDS WITH '{rng.choice(('l', '1', ''))}'",
            ]
        rooms = [name for name, label in self.labels.items() if label == "Room"]
        objects = [name for name, label in self.labels.items() if label == "Object"]
        if rooms:
            forms += [f"'b' IN {rng.choice(rooms)}.scans", f"{rng.choice(rooms)}.area = {rng.choice(rooms)}.area"]
            forms.append(f"{rng.choice(rooms)} <> {rng.choice(rooms)}")
        if objects:
            forms.append(f"like({rng.choice(objects)}, object('{rng.choice(self.objects)}')) < 0.7")
        return rng.choice(forms)

    def number(self) -> str:
        options = {
            "Room": ("area", "height", "floor_elevation", "point_count"),
            "Object": ("parts", "floor_offset", "point_count", "point_count"),
            "Storey": ("index", "elevation"),
            "Opening": ("width",),
        }
        known = [(n, options[label]) for n, label in self.labels.items() if label in options]
        known += [(name, ("gap", "area")) for name in self.edges]
        name, properties = self.rng.choice(known)
        return f"{name}.{self.rng.choice(properties)}"

    def text(self) -> str | None:
        options = {"Room": ("name", "id"), "Object": ("building",), "Opening": ("kind", "state"), "Storey": ("name",)}
        known = [(n, options[label]) for n, label in self.labels.items() if label in options]
        if not known:
            return None
        name, properties = self.rng.choice(known)
        return f"{name}.{self.rng.choice(properties)}"

    def subquery(self, depth: int) -> str:
        rng = self.rng
        rooms = [name for name, label in self.labels.items() if label == "Room"]
        start = f"({rng.choice(rooms)})" if rooms and rng.random() < 0.9 else "(:Room)"
        kept = dict(self.labels), dict(self.edges), self.likes
        self.inner += 1
        for name in ("Room", "Object"):
            self.labels[f"x{self.inner}{name[0].lower()}"] = name
        inner_room, inner_object = f"x{self.inner}r", f"x{self.inner}o"
        choice = rng.random()
        if choice < 0.45 or not rooms:
            del self.labels[inner_object]
            text = f"{start}{self.room_edge()}({inner_room}:Room{' ' + self.map('Room') if rng.random() < 0.3 else ''})"
        elif choice < 0.8:
            del self.labels[inner_room]
            like = f" {self.likeness()}" if rng.random() < 0.6 else ""
            text = f"{start}-[:CONTAINS]->({inner_object}:Object{like})"
        else:
            del self.labels[inner_room], self.labels[inner_object]
            text = (
                f"{start}{self.room_edge()}({rng.choice(rooms)})"
                if rng.random() < 0.6
                else f"{start}-[:DOOR]-(:Room)-[:DOOR]-(:Room)"
            )
        if rng.random() < 0.35:
            text += f" WHERE {self.condition(max(0, depth - 1)) if rng.random() < 0.6 else self.comparison()}"
        self.labels, self.edges, self.likes = kept
        if rng.random() < 0.55:
            return f"EXISTS {{ {text} }}"
        return f"count {{ {text} }} {rng.choice(('>=', '=', '<'))} {rng.choice((0, 1, 2))}"

    # What is returned

    def returning(self) -> str:
        rng = self.rng
        names = list(self.labels)
        values = (
            [*names, *names, *(self.number() for _ in range(2)), "score"] if self._countable() else [*names, "score"]
        )
        if rng.random() < 0.25:
            return self.grouped(values)
        renamed = self.renamed()
        columns = list(dict.fromkeys(rng.sample(values, rng.randint(1, min(4, len(values))))))
        word = rng.choice(("", "", "", "", "ALL ", "DISTINCT "))
        text = f"RETURN {word}{', '.join([*columns, *(f'{value} AS {name}' for name, value in renamed.items())])}"
        if rng.random() < 0.35:
            keys = [*columns, *self._properties_of(columns)] if word == "DISTINCT " else values
            keys = [*keys, *renamed, *renamed]
            chosen = [
                f"{key}{rng.choice(('', ' DESC'))}" for key in rng.sample(keys, min(len(keys), rng.randint(1, 2)))
            ]
            text += f" ORDER BY {', '.join(chosen)}"
        if rng.random() < 0.15:
            text += f" SKIP {rng.choice((0, 1, 3))}"
        if rng.random() < 0.2:
            text += f" LIMIT {rng.choice((1, 3, 5))}"
        if rng.random() < 0.15:
            text += f" PER BUILDING {rng.choice((1, 2))}"
        return text

    def renamed(self) -> dict[str, str]:
        """Columns that are worked out, by the names that AS gives them; mostly none."""
        rng = self.rng
        if rng.random() < 0.6 or not self._countable():
            return {}
        rooms = [name for name, label in self.labels.items() if label == "Room"]
        objects = [name for name, label in self.labels.items() if label == "Object"]
        number = self.number()
        found = [f"{number} + 1", f"{number} > 9", f"-{number}", f"[{number}, 1]", "mean_score", f"{number} IS NULL"]
        if rooms:
            room = rng.choice(rooms)
            found += [f"count {{ ({room})-[:DOOR]-(:Room) }}", f"EXISTS {{ ({room})-[:STAIRS]-(x:Room) }}"]
        if objects:
            found += 2 * [f"like({rng.choice(objects)}, object('{rng.choice(self.objects)}'))"]
        return dict(zip(("v", "w"), rng.sample(found, rng.choice((1, 1, 2))), strict=False))

    def _properties_of(self, columns: list[str]) -> list[str]:
        """Properties of the nodes that are returned; ORDER BY may take them after DISTINCT."""
        return [f"{name}.building" for name in columns if name in self.labels]

    def _countable(self) -> bool:
        return any(label != "Building" for label in self.labels.values())

    def grouped(self, values: list[str]) -> str:
        rng = self.rng
        keys = list(dict.fromkeys(rng.sample(values, rng.choice((0, 1, 1, 2)))))
        number, name = self.number(), rng.choice(list(self.labels))
        functions = ["count(*)", f"count(DISTINCT {name})", f"avg({number})", f"min({number})", f"max({number})"]
        functions += [f"sum({number})", f"collect({number})", f"collect(DISTINCT {name})", f"stDev({number})"]
        functions += [f"percentileCont({number}, 0.4)", f"percentileDisc({number}, 0.5)", f"stDevP({number})"]
        functions += [f"count({number})", "min(score)"]
        columns = [*keys, *rng.sample(functions, rng.randint(1, 3))]
        rng.shuffle(columns)
        text = f"RETURN {', '.join(columns)}"
        if rng.random() < 0.4:
            text += f" ORDER BY {rng.choice(columns)}{rng.choice(('', ' DESC'))}"
        return text + (f" LIMIT {rng.choice((1, 2))}" if rng.random() < 0.2 else "")
