"""What counts as an object."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ObjectParameters:
    """How points of a room become objects.

    Attributes
    ----------
    min_side_surfels
        Least number of surfels of a plane in a room.
    join_angle_deg, join_offset_m
        Patches of a wall are one side up to this turn and offset.
    clearance_m
        Points this close to a wall, floor or ceiling belong to it.
    max_reveal_m
        How deep the reveals of doors and windows are.
    max_riser_m
        What lies so far under the tread of a stair belongs to the stair.
    ceiling_reach_m
        A side that ends closer to the ceiling than this is a wall; others are fronts and backs of furniture.
    floor_reach_m
        Upward planes up to this far above the floor are floor.
    min_headroom_m
        Downward planes this far above the floor are ceiling.
    min_platform_m2
        Upward planes of this area are floor at any height; no bed or table is so large.
    min_slope_m2
        Oblique planes of this area are roof or ramp.
    min_incidence_deg
        Surfels that a ray met at a sharper angle are veils between edges.
    outlier_neighbours, outlier_deviations
        k and α of the outlier filter: points whose mean distance to their k nearest lies above μ + ασ go.
    voxel_m
        Points are linked by voxels of this side.
    link_m
        Points closer than this belong to one segment.
    min_extent_m, min_voxels
        Smallest segment.
    gap_m
        Segments closer than this are combined.
    near_m
        Segments closer than this are NEAR each other.
    partners
        A segment is combined with at most so many others, the nearest ones.
    max_combination_m
        Longest side of a combination.
    """

    min_side_surfels: int = 20
    join_angle_deg: float = 8.0
    join_offset_m: float = 0.02
    clearance_m: float = 0.02
    max_reveal_m: float = 0.5
    max_riser_m: float = 0.25
    ceiling_reach_m: float = 0.25
    floor_reach_m: float = 0.1
    min_headroom_m: float = 1.9
    min_platform_m2: float = 5.0
    min_slope_m2: float = 1.5
    min_incidence_deg: float = 8.0
    outlier_neighbours: int = 8
    outlier_deviations: float = 2.0
    voxel_m: float = 0.03
    link_m: float = 0.08
    min_extent_m: float = 0.15
    min_voxels: int = 25
    gap_m: float = 0.3
    near_m: float = 0.5
    partners: int = 5
    max_combination_m: float = 3.0
