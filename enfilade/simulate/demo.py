"""The built-in demo building: two storeys, fourteen rooms, furniture, all from code.

The paper's question has answers in it: the hall (about 15 m², with the stairs up) has doors to a bathroom of about
11 m² and to a guest room of about 15 m², each with a basin; a third basin is upstairs.
"""

from __future__ import annotations

from .build import build
from .furniture import basin, bathtub, bed, cabinet, chair, shelf, sofa, table, toilet, wardrobe
from .plan import Hole, Leaf, Level, Piece, Plan, Run, Space, Stairs, rectangle
from .scene import Scene
from .solids import Mesh

NORTH, WEST, SOUTH, EAST = 0.0, 90.0, 180.0, -90.0
"""The way a piece of furniture has its back."""


def demo_scene() -> Scene:
    """Return the built-in demo building, furnished."""
    return build(demo_plan())


def basin_mesh() -> Mesh:
    """Return a basin to ask with: of another size than those in the demo building."""
    return basin(width=0.56, depth=0.42, height=0.82)


def demo_plan() -> Plan:
    """Return the plan of the demo building."""
    flight = Run((1.3, 5.7), (5.0, 5.7), 1.0, 0.0, 2.9, 15)
    balustrades = (((2.01, 5.16), (5.0, 5.16)), ((2.01, 5.12), (2.01, 6.2)))
    stairs = Stairs(("Hall", "Landing"), (flight,), rectangle(2.05, 5.0, 5.2, 6.2), balustrades=balustrades)
    return Plan("demo", rectangle(0.0, 12.6, 0.0, 10.5), (_ground(), _upper()), (stairs,))


def _ground() -> Level:
    spaces = (
        Space(
            "Bath",
            rectangle(0.3, 3.85, 0.3, 3.45),
            (
                Piece("basin", basin(), (1.35, 0.56), SOUTH),
                Piece("toilet", toilet(), (0.66, 1.9), WEST),
                Piece("bathtub", bathtub(), (3.45, 1.2)),
            ),
        ),
        Space(
            "Study",
            rectangle(4.0, 6.05, 0.3, 3.45),
            (
                Piece("table", table(1.2, 0.65), (4.68, 0.7), SOUTH),
                Piece("chair", chair(), (4.7, 1.35), SOUTH),
                Piece("shelf", shelf(1.0), (4.18, 2.5), WEST),
            ),
        ),
        Space("Hall", rectangle(0.3, 6.05, 3.6, 6.2), (Piece("cabinet", cabinet(0.9, 0.35, 0.8), (5.86, 5.6), EAST),)),
        Space("Kitchen", rectangle(6.25, 12.3, 0.3, 3.45), _kitchen()),
        Space("Living room", rectangle(6.25, 12.3, 3.6, 10.2), _living_room()),
        Space(
            "Guest room",
            rectangle(0.3, 4.23, 6.35, 10.2),
            (
                Piece("bed", bed(), (3.6, 9.1), NORTH),
                Piece("basin", basin(0.48, 0.36, 0.8), (0.49, 8.0), WEST),
                Piece("wardrobe", wardrobe(1.2), (3.9, 7.2), EAST),
                Piece("chair", chair(), (1.5, 9.85), NORTH),
            ),
        ),
        Space(
            "Storage",
            rectangle(4.35, 6.05, 6.35, 10.2),
            (
                Piece("shelf", shelf(1.0, 0.4), (4.56, 7.2), WEST),
                Piece("shelf", shelf(0.8, 0.4, 1.5, 4), (5.2, 9.98), NORTH),
            ),
        ),
    )
    return Level("Ground floor", 0.0, 2.6, spaces, _ground_holes())


def _kitchen() -> tuple[Piece, ...]:
    units = tuple(Piece("kitchen unit", cabinet(), (6.56 + 0.6 * k, 0.6), SOUTH) for k in range(4))
    chairs = tuple(
        Piece("chair", chair(), (10.6 + dx, 1.75 + dy), back)
        for dx, dy, back in ((-0.35, 0.62, NORTH), (0.4, 0.66, NORTH), (-0.4, -0.64, SOUTH), (0.35, -0.6, SOUTH))
    )
    return (*units, Piece("table", table(1.6, 0.9), (10.6, 1.75)), *chairs)


def _living_room() -> tuple[Piece, ...]:
    return (
        Piece("sofa", sofa(), (8.6, 9.7), NORTH),
        Piece("sofa", sofa(1.0), (6.8, 6.7), WEST),
        Piece("low table", table(1.1, 0.6, 0.42), (8.6, 8.4)),
        Piece("shelf", shelf(1.2), (12.12, 4.5), EAST),
        Piece("shelf", shelf(0.9, 0.35, 1.2, 4), (12.1, 9.5), EAST),
        Piece("table", table(1.2, 1.2), (10.4, 5.6)),
        Piece("chair", chair(), (9.6, 5.6), WEST),
        Piece("chair", chair(), (11.25, 5.7), EAST),
    )


def _ground_holes() -> tuple[Hole, ...]:
    return (
        Hole("window", (None, "Bath"), (2.2, 0.15), 0.9, 0.7, sill=1.5),
        Hole("window", (None, "Study"), (5, 0.15), 1.2, 1.2, sill=0.9),
        Hole("window", (None, "Kitchen"), (8, 0.15), 1.8, 1.1, sill=1.05),
        Hole("window", (None, "Kitchen"), (11, 0.15), 1.2, 1.3, sill=0.9),
        Hole("window", (None, "Living room"), (12.45, 7.2), 2.4, 1.9, sill=0.4),
        Hole("window", (None, "Living room"), (8.6, 10.35), 1.8, 1.2, sill=0.9),
        Hole("window", (None, "Guest room"), (2.2, 10.35), 1.5, 1.2, sill=0.9),
        Hole("door", (None, "Hall"), (0.15, 4.4), 1.0, 2.1, leaf=Leaf()),
        Hole("door", ("Bath", "Hall"), (2.9, 3.525), 0.8, 2.0),
        Hole("door", ("Study", "Hall"), (5.2, 3.525), 0.9, 2.05),
        Hole("passage", ("Kitchen", "Living room"), (9.5, 3.525), 1.5, 2.6),
        Hole("door", ("Kitchen", "Study"), (6.15, 2.2), 0.7, 2.0),
        Hole("door", ("Living room", "Hall"), (6.15, 4.4), 1.2, 2.1),
        Hole("door", ("Living room", "Storage"), (6.15, 8.4), 0.8, 2.0, leaf=Leaf()),
        Hole("door", ("Hall", "Guest room"), (0.8, 6.275), 0.85, 2.0),
    )


def _upper() -> Level:
    return Level("Upper floor", 2.9, 5.4, _upper_spaces(), _upper_holes())


def _upper_spaces() -> tuple[Space, ...]:
    return (
        Space(
            "Bedroom 1",
            rectangle(0.3, 4.6, 0.3, 3.45),
            (
                Piece("bed", bed(1.6), (1.45, 1.33), SOUTH),
                Piece("bedside cabinet", cabinet(0.4, 0.38, 0.5), (2.55, 0.5), SOUTH),
                Piece("wardrobe", wardrobe(1.8), (4.28, 1.6), EAST),
            ),
        ),
        Space(
            "Shower room",
            rectangle(4.75, 7.4, 0.3, 3.45),
            (
                Piece("basin", basin(0.75, 0.5, 0.88), (7.13, 2.2), EAST),
                Piece("toilet", toilet(0.36, 0.62), (5.08, 1.0), WEST),
                Piece("cabinet", cabinet(), (7.09, 0.62), EAST),
            ),
        ),
        Space(
            "Bedroom 2",
            rectangle(7.55, 12.3, 0.3, 3.45),
            (
                Piece("bed", bed(1.2), (11.6, 1.35), SOUTH),
                Piece("wardrobe", wardrobe(1.5), (7.87, 1.3), WEST),
                Piece("table", table(1.3, 0.65), (9.3, 0.66), SOUTH),
                Piece("chair", chair(), (9.25, 1.3), NORTH),
            ),
        ),
        Space("Landing", rectangle(0.3, 6.1, 3.6, 6.2), (Piece("shelf", shelf(0.8, 0.3, 1.1, 3), (0.47, 4.3), WEST),)),
        Space(
            "Corridor", rectangle(6.25, 12.3, 3.6, 5.0), (Piece("cabinet", cabinet(1.0, 0.35, 0.9), (8.0, 4.8), NORTH),)
        ),
        Space(
            "Bedroom 3",
            rectangle(0.3, 6.1, 6.35, 10.2),
            (
                Piece("bed", bed(1.8, 2.1), (1.37, 8.2), WEST),
                Piece("bedside cabinet", cabinet(0.45, 0.4, 0.5), (0.52, 9.6), WEST),
                Piece("wardrobe", wardrobe(2.0, 0.6, 2.1), (4.6, 9.88), NORTH),
                Piece("sofa", sofa(0.95, 0.8), (5.5, 7.2), EAST),
            ),
        ),
        Space("Studio", rectangle(6.25, 12.3, 5.15, 10.2), _studio()),
    )


def _studio() -> tuple[Piece, ...]:
    tables = tuple(Piece("table", table(1.5, 0.75), (x, 7.8)) for x in (7.9, 9.9))
    chairs = tuple(Piece("chair", chair(), (x, 7.2), SOUTH) for x in (7.8, 10.0))
    return (
        *tables,
        *chairs,
        Piece("shelf", shelf(1.0), (6.43, 9.4), WEST),
        Piece("shelf", shelf(1.0), (6.43, 8.3), WEST),
        Piece("table", table(0.9, 0.9, 1.05), (11.2, 9.0)),
        Piece("cabinet", cabinet(1.2, 0.45, 0.75), (12.05, 6.4), EAST),
    )


def _upper_holes() -> tuple[Hole, ...]:
    return (
        Hole("window", (None, "Bedroom 1"), (2.9, 0.15), 1.4, 1.2, sill=0.9),
        Hole("window", (None, "Shower room"), (6.1, 0.15), 0.7, 0.7, sill=1.4),
        Hole("window", (None, "Bedroom 2"), (9.6, 0.15), 1.5, 1.2, sill=0.9),
        Hole("window", (None, "Corridor"), (12.45, 4.3), 0.9, 1.3, sill=0.9),
        Hole("window", (None, "Studio"), (12.45, 7.9), 1.8, 1.4, sill=0.9),
        Hole("window", (None, "Studio"), (10.4, 10.35), 1.5, 1.4, sill=0.9),
        Hole("window", (None, "Studio"), (8, 10.35), 1.5, 1.4, sill=0.9),
        Hole("window", (None, "Bedroom 3"), (2.3, 10.35), 1.5, 1.2, sill=0.9),
        Hole("window", (None, "Landing"), (0.15, 5.3), 0.9, 1.2, sill=0.9),
        Hole("door", ("Bedroom 1", "Landing"), (3.5, 3.525), 0.8, 2.0),
        Hole("door", ("Shower room", "Landing"), (5.4, 3.525), 0.7, 2.0),
        Hole("door", ("Bedroom 2", "Corridor"), (8.9, 3.525), 0.85, 2.0),
        Hole("door", ("Corridor", "Landing"), (6.175, 4.3), 0.9, 2.05),
        Hole("door", ("Landing", "Bedroom 3"), (1.2, 6.275), 0.9, 2.0),
        Hole("door", ("Corridor", "Studio"), (10.45, 5.075), 1.3, 2.1),
    )
