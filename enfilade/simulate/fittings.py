"""More furniture from code: things that hang on walls and ceilings, stand on tables, lie about. Metres.

As in `furniture`, each stands on z = 0 about the origin, its back towards +y.
"""

from __future__ import annotations

from .solids import Mesh, block, box, cylinder, lathe, merge


def desk(width: float = 1.4, depth: float = 0.7, height: float = 0.73) -> Mesh:
    """Return a desk on two side panels, with a modesty panel at the back."""
    sides = [block((s * (width / 2 - 0.015), 0.0), (0.03, depth - 0.05), 0.0, height - 0.03) for s in (-1, 1)]
    back = block((0.0, depth / 2 - 0.1), (width - 0.06, 0.02), 0.3, height - 0.03)
    return merge([block((0.0, 0.0), (width, depth), height - 0.03, height), back, *sides])


def monitor(width: float = 0.55, height: float = 0.34) -> Mesh:
    """Return a computer screen on its foot."""
    foot = block((0.0, 0.0), (0.22, 0.2), 0.0, 0.015)
    neck = block((0.0, 0.03), (0.05, 0.03), 0.015, 0.2)
    return merge([foot, neck, block((0.0, 0.0), (width, 0.03), 0.12, 0.12 + height)])


def office_chair(height: float = 1.0) -> Mesh:
    """Return a swivel chair."""
    feet = merge(block((0.0, 0.17), (0.05, 0.3), 0.04, 0.09).turned(72.0 * k) for k in range(5))
    post = cylinder((0.0, 0.0), 0.03, 0.05, 0.44, sides=8)
    seat = cylinder((0.0, 0.0), 0.24, 0.44, 0.52, sides=12)
    return merge([feet, post, seat, block((0.0, 0.22), (0.42, 0.05), 0.6, height)])


def wall_cupboard(width: float = 0.9, depth: float = 0.34, height: float = 0.7) -> Mesh:
    """Return a cupboard to hang on a wall."""
    return merge([block((0.0, 0.0), (width, depth), 0.0, height), block((0.0, -depth / 2), (0.02, 0.03), 0.1, 0.25)])


def radiator(width: float = 1.0, height: float = 0.6, depth: float = 0.1) -> Mesh:
    """Return a radiator of columns between two bars."""
    count = max(3, round(width / 0.08))
    step = width / count
    ribs = [block((-width / 2 + (k + 0.5) * step, 0.0), (0.6 * step, depth), 0.0, height) for k in range(count)]
    bars = [block((0.0, 0.0), (width, 0.5 * depth), z, z + 0.05) for z in (0.03, height - 0.08)]
    return merge([*ribs, *bars])


def plant(height: float = 1.2, radius: float = 0.3) -> Mesh:
    """Return a plant in a pot."""
    pot = lathe([(0.0, 0.0), (0.13, 0.0), (0.17, 0.3), (0.0, 0.3)], 12)
    stem = cylinder((0.0, 0.0), 0.02, 0.3, 0.6 * height, sides=6)
    leaves = [
        box([-0.05, 0.02, 0.0], [0.05, radius, 0.015]).moved([0.0, 0.0, height * (0.45 + 0.06 * k)]).turned(67.0 * k)
        for k in range(9)
    ]
    return merge([pot, stem, *leaves])


def floor_lamp(height: float = 1.6) -> Mesh:
    """Return a standard lamp."""
    foot = cylinder((0.0, 0.0), 0.15, 0.0, 0.03, sides=12)
    shade = lathe([(0.2, height - 0.3), (0.12, height), (0.0, height), (0.11, height - 0.01), (0.19, height - 0.3)], 12)
    return merge([foot, cylinder((0.0, 0.0), 0.015, 0.03, height - 0.05, sides=6), shade])


def ceiling_lamp(drop: float = 0.5, radius: float = 0.2) -> Mesh:
    """Return a lamp that hangs `drop` below the ceiling; z = 0 is its lower edge."""
    shade = lathe([(radius, 0.0), (0.4 * radius, 0.2), (0.0, 0.2), (0.35 * radius, 0.19), (0.95 * radius, 0.0)], 12)
    return merge([shade, cylinder((0.0, 0.0), 0.01, 0.2, drop, sides=6)])


def carton(width: float = 0.4, depth: float = 0.3, height: float = 0.3) -> Mesh:
    """Return a box."""
    return block((0.0, 0.0), (width, depth), 0.0, height)


def bin_bag(radius: float = 0.25, height: float = 0.5) -> Mesh:
    """Return a bag or a bucket."""
    return lathe([(0.0, 0.0), (0.8 * radius, 0.0), (radius, 0.4 * height), (0.4 * radius, height), (0.0, height)], 10)


def books(width: float = 0.35) -> Mesh:
    """Return a row of books."""
    count = max(2, round(width / 0.045))
    step = width / count
    heights = [0.18 + 0.05 * ((7 * k) % 3) for k in range(count)]
    return merge(block((-width / 2 + (k + 0.5) * step, 0.0), (0.9 * step, 0.16), 0.0, h) for k, h in enumerate(heights))


def picture(width: float = 0.6, height: float = 0.45) -> Mesh:
    """Return a framed picture."""
    return block((0.0, 0.0), (width, 0.025), 0.0, height)


def fridge(width: float = 0.6, height: float = 1.8) -> Mesh:
    """Return a fridge with a handle."""
    return merge([block((0.0, 0.0), (width, 0.62), 0.02, height), block((0.25, -0.33), (0.02, 0.04), 0.7, 1.2)])


def shower(size: float = 0.85) -> Mesh:
    """Return a shower tray with its pole and head."""
    tray = block((0.0, 0.0), (size, size), 0.0, 0.12)
    pole = cylinder((0.0, size / 2 - 0.06), 0.015, 0.12, 2.0, sides=6)
    return merge([tray, pole, cylinder((0.0, size / 2 - 0.18), 0.1, 1.95, 1.98, sides=10)])


def bench_seat(width: float = 1.2) -> Mesh:
    """Return a bench on two blocks."""
    feet = [block((s * (width / 2 - 0.15), 0.0), (0.08, 0.35), 0.0, 0.4) for s in (-1, 1)]
    return merge([block((0.0, 0.0), (width, 0.4), 0.4, 0.45), *feet])


def low_table(width: float = 1.0, depth: float = 0.6, height: float = 0.42) -> Mesh:
    """Return a coffee table on a plinth."""
    return merge(
        [
            block((0.0, 0.0), (width, depth), height - 0.05, height),
            block((0.0, 0.0), (0.5 * width, 0.5 * depth), 0.0, height - 0.05),
        ]
    )


def round_table(radius: float = 0.55, height: float = 0.74) -> Mesh:
    """Return a round table on one foot."""
    foot = cylinder((0.0, 0.0), 0.5 * radius, 0.0, 0.03, sides=16)
    return merge(
        [
            foot,
            cylinder((0.0, 0.0), 0.04, 0.03, height - 0.03, sides=8),
            cylinder((0.0, 0.0), radius, height - 0.03, height, sides=24),
        ]
    )


def tree(height: float = 6.0, radius: float = 1.8) -> Mesh:
    """Return a tree: trunk and crown."""
    trunk = cylinder((0.0, 0.0), 0.18, 0.0, 0.5 * height, sides=8)
    crown = lathe(
        [
            (0.0, 0.35 * height),
            (0.7 * radius, 0.4 * height),
            (radius, 0.6 * height),
            (0.6 * radius, 0.85 * height),
            (0.0, height),
        ],
        10,
    )
    return merge([trunk, crown])
