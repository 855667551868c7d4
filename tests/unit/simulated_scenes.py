"""Small plans to scan."""

from enfilade.simulate.build import build
from enfilade.simulate.furniture import table
from enfilade.simulate.plan import Hole, Leaf, Level, Piece, Plan, Space, rectangle
from enfilade.simulate.scene import Scene


def box_room(*holes: Hole, pieces: tuple[Piece, ...] = (), garden: float = 0.0) -> Scene:
    """One room, 4 m by 3 m by 2.5 m, with holes in its south wall."""
    level = Level("Ground floor", 0.0, 2.5, (Space("Room", rectangle(0, 4, 0, 3), pieces),), holes)
    return build(Plan("box", rectangle(-0.2, 4.2, -0.2, 3.2), (level,), garden=garden))


def two_rooms(*, closed: bool = False) -> Scene:
    """Two rooms of 3 m by 3 m by 2.5 m, a 0.2 m wall with a door 0.9 m by 2 m between them, a table in the second."""
    door = Hole("door", ("Second", "First"), (3.1, 1.5), 0.9, 2.0, leaf=Leaf() if closed else None)
    spaces = (
        Space("First", rectangle(0, 3, 0, 3)),
        Space("Second", rectangle(3.2, 6.2, 0, 3), (Piece("table", table(1.2, 0.8), (5.4, 2.4)),)),
    )
    level = Level("Ground floor", 0.0, 2.5, spaces, (door,))
    return build(Plan("pair", rectangle(-0.2, 6.4, -0.2, 3.2), (level,), garden=0.0))
