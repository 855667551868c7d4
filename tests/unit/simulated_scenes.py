"""Small plans to scan."""

from enfilade.simulate.furniture import table
from enfilade.simulate.plan import Hole, Level, Piece, Plan, Space, Wall, build
from enfilade.simulate.scene import Scene


def box_room(*holes: Hole, pieces: tuple[Piece, ...] = (), garden: float = 0.0) -> Scene:
    """One room, 4 m by 3 m by 2.5 m, with holes in its south wall."""
    walls = (
        Wall((-0.2, -0.1), (4.2, -0.1), 0.2, holes),
        Wall((-0.2, 3.1), (4.2, 3.1), 0.2),
        Wall((-0.1, 0.0), (-0.1, 3.0), 0.2),
        Wall((4.1, 0.0), (4.1, 3.0), 0.2),
    )
    level = Level("Ground floor", 0.0, 2.5, (Space("Room", (0, 4, 0, 3), pieces),), walls)
    return build(Plan("box", (-0.2, 4.2, -0.2, 3.2), (level,), garden=garden))


def two_rooms(*, closed: bool = False) -> Scene:
    """Two rooms of 3 m by 3 m by 2.5 m, a 0.2 m wall with a door 0.9 m by 2 m between them, a table in the second."""
    door = Hole("door", 1.5, 0.9, 2.0, ("Second", "First"), closed=closed)
    walls = (
        Wall((-0.2, -0.1), (6.4, -0.1), 0.2),
        Wall((-0.2, 3.1), (6.4, 3.1), 0.2),
        Wall((-0.1, 0.0), (-0.1, 3.0), 0.2),
        Wall((6.3, 0.0), (6.3, 3.0), 0.2),
        Wall((3.1, 0.0), (3.1, 3.0), 0.2, (door,)),
    )
    spaces = (
        Space("First", (0, 3, 0, 3)),
        Space("Second", (3.2, 6.2, 0, 3), (Piece("table", table(1.2, 0.8), (5.4, 2.4)),)),
    )
    level = Level("Ground floor", 0.0, 2.5, spaces, walls)
    return build(Plan("pair", (-0.2, 6.4, -0.2, 3.2), (level,), garden=0.0))
