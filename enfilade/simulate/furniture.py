"""Furniture from code: each piece stands on z = 0 about the origin, its back towards +y. Metres."""

from __future__ import annotations

from .solids import Mesh, block, cylinder, lathe, merge


def basin(width: float = 0.6, depth: float = 0.48, height: float = 0.85) -> Mesh:
    """Return a wash basin: an oval bowl with a ledge and a tap, on a pedestal."""
    rim, bowl_foot = height, height - 0.2
    pedestal = lathe([(0.13, 0.0), (0.10, 0.08), (0.08, 0.4), (0.11, bowl_foot)])
    bowl = lathe(
        [
            (0.0, bowl_foot),
            (0.11, bowl_foot),
            (0.40, rim - 0.06),
            (0.50, rim - 0.02),
            (0.50, rim),
            (0.45, rim),
            (0.36, rim - 0.08),
            (0.15, rim - 0.15),
            (0.0, rim - 0.16),
        ]
    )
    ledge = block((0.0, 0.44 * depth), (0.8 * width, 0.12 * depth), rim - 0.08, rim)
    tap = merge(
        [
            cylinder((0.0, 0.42 * depth), 0.02, rim, rim + 0.16, sides=8),
            block((0.0, 0.32 * depth), (0.03, 0.22 * depth), rim + 0.13, rim + 0.16),
        ]
    )
    return merge([pedestal, bowl.scaled([width, depth, 1.0]), ledge, tap])


def toilet(width: float = 0.38, depth: float = 0.68) -> Mesh:
    """Return a toilet: bowl, seat and cistern."""
    profile = [
        (0.28, 0.0),
        (0.24, 0.1),
        (0.34, 0.25),
        (0.5, 0.36),
        (0.5, 0.42),
        (0.32, 0.42),
        (0.12, 0.25),
        (0.0, 0.22),
    ]
    bowl_depth = depth - 0.2
    bowl = lathe(profile).scaled([width, bowl_depth, 1.0]).moved([0.0, -depth / 2 + bowl_depth / 2, 0.0])
    neck = block((0.0, depth / 2 - 0.2), (0.22, 0.2), 0.0, 0.4)
    cistern = block((0.0, depth / 2 - 0.09), (width + 0.02, 0.18), 0.4, 0.8)
    return merge([bowl, neck, cistern])


def bathtub(width: float = 0.75, length: float = 1.7, height: float = 0.56) -> Mesh:
    """Return a bathtub, its long side along y."""
    rim = 0.07
    x, y = width / 2, length / 2
    sides = [block((side * (x - rim / 2), 0.0), (rim, length), 0.0, height) for side in (-1, 1)] + [
        block((0.0, side * (y - rim / 2)), (width - 2 * rim, rim), 0.0, height) for side in (-1, 1)
    ]
    return merge([*sides, block((0.0, 0.0), (width - 2 * rim, length - 2 * rim), 0.0, 0.14)])


def table(width: float = 1.4, depth: float = 0.8, height: float = 0.75, top: float = 0.04) -> Mesh:
    """Return a table with four legs."""
    return merge([block((0.0, 0.0), (width, depth), height - top, height), *_legs(width, depth, height - top)])


def chair(width: float = 0.45, depth: float = 0.46, seat: float = 0.46, height: float = 0.92) -> Mesh:
    """Return a chair with four legs, a seat and a slatted back."""
    posts = [block((side * (width / 2 - 0.02), depth / 2 - 0.02), (0.04, 0.04), seat, height) for side in (-1, 1)]
    slats = [block((0.0, depth / 2 - 0.02), (width - 0.08, 0.02), z, z + 0.09) for z in (seat + 0.16, height - 0.1)]
    return merge(
        [block((0.0, 0.0), (width, depth), seat - 0.04, seat), *_legs(width, depth, seat - 0.04), *posts, *slats]
    )


def bed(width: float = 0.95, length: float = 2.05, height: float = 0.5) -> Mesh:
    """Return a bed: frame on legs, mattress, pillow, headboard at the back."""
    frame = block((0.0, 0.0), (width, length), 0.2, 0.32)
    mattress = block((0.0, -0.02), (width - 0.06, length - 0.1), 0.32, height)
    pillow = block((0.0, length / 2 - 0.3), (0.7 * width, 0.4), height, height + 0.1)
    headboard = block((0.0, length / 2 - 0.02), (width, 0.04), 0.2, height + 0.4)
    return merge([frame, mattress, pillow, headboard, *_legs(width, length, 0.2)])


def sofa(width: float = 1.9, depth: float = 0.88, height: float = 0.8) -> Mesh:
    """Return a sofa: seat, back and two arms."""
    arms = [block((side * (width / 2 - 0.09), 0.0), (0.18, depth), 0.08, 0.6) for side in (-1, 1)]
    seat = block((0.0, -0.05), (width - 0.36, depth - 0.1), 0.08, 0.43)
    back = block((0.0, depth / 2 - 0.11), (width - 0.36, 0.22), 0.08, height)
    return merge([seat, back, *arms, *_legs(width, depth, 0.08)])


def shelf(width: float = 0.9, depth: float = 0.32, height: float = 1.9, boards: int = 5) -> Mesh:
    """Return an open shelf with a back panel."""
    sides = [block((side * (width / 2 - 0.01), 0.0), (0.02, depth), 0.0, height) for side in (-1, 1)]
    step = (height - 0.07) / (boards - 1)
    levels = [block((0.0, 0.0), (width - 0.04, depth), 0.05 + k * step, 0.07 + k * step) for k in range(boards)]
    return merge([*sides, *levels, block((0.0, depth / 2 - 0.005), (width, 0.01), 0.0, height)])


def wardrobe(width: float = 1.5, depth: float = 0.6, height: float = 2.0) -> Mesh:
    """Return a wardrobe on a plinth, its doors with handles."""
    body = block((0.0, 0.0), (width, depth), 0.08, height)
    plinth = block((0.0, 0.03), (width - 0.04, depth - 0.06), 0.0, 0.08)
    handles = [block((x, -depth / 2 - 0.02), (0.02, 0.04), 0.95, 1.15) for x in (-0.05, 0.05)]
    return merge([body, plinth, *handles])


def cabinet(width: float = 0.6, depth: float = 0.58, height: float = 0.86) -> Mesh:
    """Return a low cabinet with a top that stands over a little, such as a kitchen unit or a washing machine."""
    body = block((0.0, 0.02), (width, depth - 0.04), 0.0, height - 0.03)
    return merge([body, block((0.0, 0.0), (width, depth), height - 0.03, height)])


def _legs(width: float, depth: float, top: float, thickness: float = 0.05) -> list[Mesh]:
    x, y = width / 2 - thickness / 2, depth / 2 - thickness / 2
    return [block((sx * x, sy * y), (thickness, thickness), 0.0, top) for sx in (-1, 1) for sy in (-1, 1)]
