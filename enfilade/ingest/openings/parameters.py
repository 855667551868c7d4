"""What counts as an opening."""

from __future__ import annotations

from dataclasses import dataclass, field

from enfilade.ingest.openings.confidence import ConfidenceParameters


@dataclass(frozen=True, slots=True)
class OpeningParameters:
    """How holes are found and told apart.

    Attributes
    ----------
    cell_m
        Cell of the grid on a wall in which rays and wall points are counted.
    bridge_m
        Gaps between rays up to this width are closed.
    surface_m
        Points this close to a wall belong to it; a ray must go so far past it to have crossed.
    front_m
        What stands this close before a wall hides it.
    max_gap_m, max_slab_m
        Thickest wall and thickest floor slab that an opening leads through.
    min_width_m, min_height_m
        Smallest opening.
    min_rays
        Fewest rays through an opening.
    min_sill_m
        A hole that starts this far above the floor is a window.
    min_headroom_m
        Lowest door or passage.
    min_lintel_m
        A hole that ends less than this below the ceiling is a passage.
    max_inset_m
        How far the leaf of a closed door lies behind its wall.
    min_closed_height_m, max_closed_width_m
        Lowest and widest closed door.
    min_side_surfels
        Least number of surfels of a wall in a room.
    join_angle_deg, join_offset_m
        Patches of a wall are one side up to this turn and offset.
    min_stairs_area_m2
        Smallest hole in a slab.
    storey_m
        Least difference of floors between rooms joined by stairs.
    max_leaf_m
        Widest leaf of a glazed door; wider panes are windows.
    least_pane
        A hole is glazed, or its leaf closed, where this share of it sends rays back.
    confidence
        Weights of the evidence.
    """

    cell_m: float = 0.025
    bridge_m: float = 0.1
    surface_m: float = 0.02
    front_m: float = 0.3
    max_gap_m: float = 0.6
    max_slab_m: float = 0.8
    min_width_m: float = 0.4
    min_height_m: float = 0.4
    min_rays: int = 20
    min_sill_m: float = 0.4
    min_headroom_m: float = 1.5
    min_lintel_m: float = 0.12
    max_inset_m: float = 0.3
    min_closed_height_m: float = 1.7
    max_closed_width_m: float = 2.6
    min_side_surfels: int = 40
    join_angle_deg: float = 8.0
    join_offset_m: float = 0.05
    min_stairs_area_m2: float = 0.3
    storey_m: float = 1.0
    max_leaf_m: float = 1.3
    least_pane: float = 0.5
    confidence: ConfidenceParameters = field(default_factory=ConfidenceParameters)
