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
    max_reveal_m, frame_m
        How deep the reveals of doors and windows are, and how wide their frames.
    room_reach_m
        A point without a surfel is in the room of a surfel this close.
    outline_reach_m
        A side this close to the room's outline may be a wall; a segment may stand out of it so far.
    wall_strip_m
        Height of the strip under the ceiling that shows the face of a wall.
    min_relief_m, max_relief_m
        What stands less proud of a wall is wall; what stands no more proud than the second is flat.
    min_board_m, min_fill
        Flat things on walls are at least so wide and high, and fill so much of their rectangle.
    max_leaf_m, min_leaf_m
        What is set back into a wall and is narrower and higher than this is the leaf of a door.
    max_leaf_thickness_m, max_hinge_m
        An open leaf is thinner, with its handles; its line passes the jamb so near, and its top the lintel.
    max_railing_m, min_railing_m, max_sill_m
        What is thinner than the first, longer than the second and stands on the floor is a railing or a low wall; so is
        what is no thicker than a reveal and lower than the third, a sill.
    max_riser_m, handrail_m
        What lies so far under the tread of a stair, or over it, belongs to the stair.
    min_soffit_m
        Flat pieces that lie oblique or level, so high over the floor, are of the ceiling.
    max_sunk_m
        What reaches farther below the floor hangs in a stair well.
    ceiling_reach_m
        A side that ends closer to the ceiling than this is a wall; others are fronts and backs of furniture.
    floor_reach_m
        Upward planes up to this far above the floor are floor.
    min_headroom_m
        Downward planes this far above the floor are ceiling.
    min_platform_m2
        Upward planes of this area in one piece are floor at any height; no bed is so large.
    min_top_m, max_top_m
        Upward planes so high over the floor are tables and counters put together, however large; stages are lower,
        galleries higher.
    min_slope_m2
        Oblique planes of this area are roof or ramp.
    min_incidence_deg
        Surfels that a ray met at a sharper angle are veils between edges.
    outlier_neighbours, outlier_deviations
        k and α of the outlier filter: points whose mean distance to their k nearest lies above μ + ασ go.
    voxel_m
        Points are linked by voxels of this side.
    link_m, sparse_link_m
        Points closer than this belong to one segment; the second for those too sparse for surfels.
    min_extent_m, min_voxels
        Smallest segment.
    min_behind_m, min_seen_through
        A ray that ends so far behind a thing went through it; what rays of another scan go through in more than this
        share is no thing.
    plan_cell_m, max_step_m
        Cells of the plan that one sees from above, and the greatest step between two of one terrace.
    min_surface_m
        Narrower parts of the plan are edges, not surfaces.
    max_stage_m, max_back_m, max_arm_m
        Two terraces may be of one piece up to the first step; up to the second where the higher is narrower than
        the third: a back or an arm.
    min_convexity, min_arm_convexity
        Share of its hull that a piece covers, and that one with an arm covers.
    min_slit_m
        Least width of a slit that parts two pieces.
    min_thing_m, min_table_m2
        A thing on a table is so much higher, a table so large.
    max_single_m, max_row_depth_m, max_table_depth_m, module_m
        Nothing is longer than the first in one piece; what is, and not deeper than the second, or the third if its top
        is level, is a row of modules (kitchen units are 0.6 m wide; desks are 0.8 m deep).
    max_unit_m, min_cupboard_m, min_front_fill
        No cupboard is wider than the first; one is as high as the second, and its front fills so much of a rectangle.
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
    frame_m: float = 0.06
    room_reach_m: float = 0.15
    outline_reach_m: float = 0.1
    wall_strip_m: float = 0.35
    min_relief_m: float = 0.01
    max_relief_m: float = 0.06
    min_board_m: float = 0.3
    min_fill: float = 0.6
    max_leaf_m: float = 1.15
    min_leaf_m: float = 1.8
    max_leaf_thickness_m: float = 0.14
    max_hinge_m: float = 0.3
    max_railing_m: float = 0.25
    min_railing_m: float = 1.5
    max_sill_m: float = 0.2
    max_riser_m: float = 0.4
    handrail_m: float = 1.25
    min_soffit_m: float = 1.7
    max_sunk_m: float = 0.25
    ceiling_reach_m: float = 0.25
    floor_reach_m: float = 0.1
    min_headroom_m: float = 1.9
    min_platform_m2: float = 8.0
    min_top_m: float = 0.65
    max_top_m: float = 1.0
    min_slope_m2: float = 1.5
    min_incidence_deg: float = 8.0
    outlier_neighbours: int = 8
    outlier_deviations: float = 2.0
    voxel_m: float = 0.03
    link_m: float = 0.08
    sparse_link_m: float = 0.12
    min_extent_m: float = 0.15
    min_voxels: int = 25
    min_behind_m: float = 0.15
    min_seen_through: float = 0.6
    plan_cell_m: float = 0.05
    max_step_m: float = 0.06
    max_stage_m: float = 0.45
    max_back_m: float = 0.85
    max_arm_m: float = 0.28
    min_surface_m: float = 0.2
    min_convexity: float = 0.92
    min_arm_convexity: float = 0.75
    min_slit_m: float = 0.04
    min_thing_m: float = 0.15
    min_table_m2: float = 0.4
    max_single_m: float = 2.25
    max_row_depth_m: float = 0.75
    max_table_depth_m: float = 0.9
    module_m: float = 0.6
    max_unit_m: float = 1.25
    min_cupboard_m: float = 0.65
    min_front_fill: float = 0.8
    gap_m: float = 0.3
    near_m: float = 0.5
    partners: int = 5
    max_combination_m: float = 3.0
