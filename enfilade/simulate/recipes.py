"""What the generated buildings are like: one recipe for each two of them, one of either half.

The building of an odd seed belongs to the develop half, that of the even seed after it to the check half. Both are made
after the same recipe, so what is hard is spread evenly over the halves, and no plan occurs in both.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

HALVES: Final = ("develop", "check")


@dataclass(frozen=True, slots=True)
class Recipe:
    """How a building is made.

    Attributes
    ----------
    name
        What kind of building, the first part of its name.
    layout
        A key of `layouts.LAYOUTS`.
    width, depth
        Least and greatest extent, metres.
    storeys
        Their number, basement and attic included.
    dwelling
        Whether people live in it; otherwise they work there.
    features
        What makes it hard, any of `FEATURES`.
    faults
        A key of `faults.FAULTS`.
    step_deg
        Angle between rays.
    area_a_scan_m2
        Floor for which there is one scan.
    room_width
        Least and greatest width of rooms in a row, metres.
    wing
        Length of a wing, metres; 0 for none.
    """

    name: str
    layout: str
    width: tuple[float, float]
    depth: tuple[float, float]
    storeys: int = 1
    dwelling: bool = True
    features: frozenset[str] = field(default_factory=frozenset)
    faults: str = "medium"
    step_deg: float = 0.5
    area_a_scan_m2: float = 25.0
    room_width: tuple[float, float] = (2.4, 4.2)
    wing: float = 0.0


FEATURES: Final[dict[str, str]] = {
    "attic": "sloped ceilings under a roof",
    "balcony": "a balcony",
    "basement": "a basement",
    "closets": "closets, mostly back to back, which make rooms L-shaped",
    "columns": "columns",
    "cramped": "much lying about",
    "double height": "a room over two storeys with a gallery",
    "few scans": "few scanner positions",
    "glass walls": "glass walls",
    "low ceilings": "ceilings of several heights",
    "many scans": "many scanner positions",
    "mirrors": "mirrors",
    "octagon": "a room with eight sides",
    "open plan": "rooms without walls between them",
    "outside scans": "scans outside",
    "paired doors": "doors side by side",
    "raised floors": "split levels",
    "round room": "a round room",
    "shut": "many closed doors",
    "thick walls": "thick walls",
    "thin walls": "thin walls",
    "turned": "turned in plan and far from the origin",
    "unscanned": "rooms without scans",
    "wide passages": "wide passages, with and without a lintel",
    "wing": "a wing",
}
"""What a building may have that makes it hard."""


def _with(*names: str) -> frozenset[str]:
    return frozenset(names)


_SMALL, _HOUSE, _LONG = ((7.5, 9.5), (6.0, 7.5)), ((11.0, 13.5), (9.0, 11.0)), ((20.0, 28.0), (11.0, 13.0))

RECIPES: Final[tuple[Recipe, ...]] = (
    Recipe("flat", "flat", *_SMALL, faults="light", features=_with("mirrors", "paired doors")),
    Recipe("house", "hall", *_HOUSE, 2, features=_with("closets", "turned", "open plan", "balcony")),
    Recipe(
        "office", "corridor", *_LONG, dwelling=False, features=_with("glass walls", "columns", "open plan", "turned")
    ),
    Recipe(
        "villa", "suite", (12.0, 15.0), (10.0, 12.0), 2, features=_with("round room", "wide passages", "raised floors")
    ),
    Recipe("flat", "flat", (9.0, 11.5), (7.0, 8.5), faults="heavy", features=_with("cramped", "closets", "few scans")),
    Recipe(
        "house", "flat", (10.0, 12.5), (8.5, 10.0), 3, features=_with("basement", "attic", "paired doors", "unscanned")
    ),
    Recipe(
        "practice",
        "corridor",
        (14.0, 18.0),
        (9.5, 11.0),
        dwelling=False,
        features=_with("paired doors", "shut", "turned"),
    ),
    Recipe(
        "loft",
        "suite",
        (11.0, 14.0),
        (9.0, 10.0),
        faults="light",
        features=_with("columns", "wide passages", "mirrors"),
    ),
    Recipe(
        "office",
        "corridor",
        (17.0, 21.0),
        (11.0, 12.5),
        2,
        dwelling=False,
        faults="light",
        features=_with("glass walls", "low ceilings", "unscanned", "wing"),
        wing=7.5,
        step_deg=0.6,
    ),
    Recipe(
        "house", "hall", *_HOUSE, 2, faults="heavy", features=_with("double height", "wide passages", "outside scans")
    ),
    Recipe("flat", "suite", (8.0, 10.0), (7.0, 8.5), features=_with("thin walls", "octagon", "turned", "many scans")),
    Recipe(
        "school",
        "corridor",
        (24.0, 30.0),
        (12.0, 14.0),
        dwelling=False,
        features=_with("columns", "paired doors"),
        room_width=(4.5, 8.0),
    ),
    Recipe("house", "flat", (9.5, 11.5), (8.5, 9.5), 2, features=_with("attic", "closets", "thick walls", "mirrors")),
    Recipe(
        "gallery",
        "suite",
        (13.0, 16.0),
        (11.0, 13.0),
        dwelling=False,
        features=_with("wide passages", "turned", "octagon", "thick walls"),
    ),
    Recipe("flat", "flat", _SMALL[0], (6.5, 8.0), faults="heavy", features=_with("open plan", "outside scans", "shut")),
    Recipe(
        "hotel",
        "corridor",
        (18.0, 23.0),
        (11.5, 12.5),
        2,
        features=_with("closets", "paired doors", "unscanned"),
        room_width=(3.2, 4.4),
        step_deg=0.6,
    ),
    Recipe(
        "house",
        "hall",
        *_HOUSE,
        3,
        faults="light",
        features=_with("basement", "raised floors", "outside scans", "balcony"),
    ),
    Recipe(
        "office",
        "corridor",
        (26.0, 32.0),
        (12.0, 13.5),
        dwelling=False,
        faults="heavy",
        features=_with("glass walls", "turned", "few scans", "cramped"),
        step_deg=0.6,
    ),
    Recipe(
        "flat", "flat", (10.0, 12.0), (8.0, 9.0), features=_with("round room", "low ceilings", "balcony", "mirrors")
    ),
    Recipe(
        "house",
        "suite",
        (10.0, 12.0),
        (9.0, 10.0),
        2,
        faults="heavy",
        features=_with("thin walls", "shut", "unscanned"),
    ),
    Recipe(
        "clinic",
        "corridor",
        (15.0, 19.0),
        (10.5, 12.0),
        2,
        dwelling=False,
        features=_with("wing", "paired doors", "mirrors", "turned"),
        wing=6.5,
        step_deg=0.6,
    ),
    Recipe(
        "cottage",
        "flat",
        (8.0, 10.0),
        (6.5, 8.0),
        features=_with("attic", "thick walls", "low ceilings"),
        faults="light",
    ),
    Recipe("house", "hall", *_HOUSE, 2, features=_with("open plan", "wide passages", "cramped", "few scans")),
    Recipe(
        "hall",
        "corridor",
        (18.0, 22.0),
        (13.0, 16.0),
        dwelling=False,
        features=_with("columns", "open plan", "many scans"),
        step_deg=0.6,
    ),
    Recipe(
        "flat", "suite", (9.0, 11.0), (8.0, 9.5), faults="heavy", features=_with("mirrors", "wide passages", "turned")
    ),
    Recipe(
        "house",
        "flat",
        (10.0, 12.0),
        (8.5, 10.0),
        2,
        features=_with("raised floors", "closets", "outside scans", "turned"),
    ),
    Recipe(
        "office",
        "corridor",
        (18.0, 22.0),
        (11.0, 12.5),
        2,
        dwelling=False,
        features=_with("open plan", "glass walls", "basement", "shut"),
        step_deg=0.6,
    ),
    Recipe(
        "villa",
        "hall",
        (13.0, 15.0),
        (10.0, 12.0),
        2,
        faults="light",
        features=_with("double height", "closets", "mirrors", "turned"),
    ),
    Recipe("flat", "flat", _SMALL[0], (6.5, 7.5), features=_with("thin walls", "cramped", "unscanned", "paired doors")),
    Recipe(
        "row house", "flat", (8.5, 9.5), (8.0, 9.0), 3, faults="heavy", features=_with("attic", "turned", "balcony")
    ),
    Recipe(
        "palace",
        "suite",
        (15.0, 18.0),
        (12.0, 14.0),
        faults="light",
        features=_with("round room", "thick walls", "columns", "raised floors"),
    ),
    Recipe(
        "office",
        "corridor",
        (26.0, 30.0),
        (12.0, 13.5),
        2,
        dwelling=False,
        features=_with("wing", "glass walls", "open plan", "low ceilings", "turned"),
        wing=8.0,
        step_deg=0.6,
    ),
)
"""Two buildings are made after each, of seeds 2 k + 1 and 2 k + 2."""


def recipe_of(seed: int) -> Recipe:
    """Return the recipe of a seed; seeds beyond the corpus go round again."""
    return RECIPES[(seed - 1) // 2 % len(RECIPES)]


def half_of(seed: int) -> str:
    """Return the half of the corpus that the building of a seed belongs to."""
    return HALVES[(seed - 1) % 2]


CORPUS: Final = tuple(range(1, 2 * len(RECIPES) + 1))
"""Seeds of the corpus."""
