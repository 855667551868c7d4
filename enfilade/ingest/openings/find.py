"""Find all openings of a building: through walls, through slabs, and where two rooms meet without a wall."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from itertools import chain

from enfilade.ingest.openings.behind import within_room
from enfilade.ingest.openings.blind import find_blind_holes, is_doorway, open_blind
from enfilade.ingest.openings.contacts import contact_sides
from enfilade.ingest.openings.evidence import Walls
from enfilade.ingest.openings.holes import Hole, find_holes
from enfilade.ingest.openings.leads import group_holes, without_rivals
from enfilade.ingest.openings.leaves import with_leaves
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import SideView, SideViews, rays_of, told_by_sight
from enfilade.ingest.openings.sight import Sight
from enfilade.ingest.openings.slabs import floor_sides, open_slab
from enfilade.ingest.openings.walls import open_walls
from enfilade.ingest.records import Neighbour, Opening, Planes, Room, RoomLabels, Surfels, ThinnedCloud
from enfilade.ingest.sides import cut_by_room, join_patches


def find_openings(
    cloud: ThinnedCloud,
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    rooms: tuple[Room, ...],
    neighbours: tuple[Neighbour, ...],
    parameters: OpeningParameters | None = None,
) -> tuple[Opening, ...]:
    """Find doors, passages, windows, stairs and hatches, with size, place and the rays that went through.

    The rays that leave a room or come into it are cut with the room's walls; where many cross a wall in cells that
    hold no wall points, there is a hole. The hole's edges are measured between the outermost rays and the first
    wall points; the rooms at both ends of its rays, the nearest counting most, tell where it leads. Holes in the
    two sides of a wall are one opening.

    Parameters
    ----------
    cloud, surfels, planes, labels, rooms, neighbours
        What the stages before found.
    parameters
        Sizes and thresholds.

    Returns
    -------
    Openings ordered by rooms and place; positions in metres, relative to the building's origin.
    """
    chosen = parameters if parameters is not None else OpeningParameters()
    rays = rays_of(cloud, surfels, labels)
    known = {room.number: room for room in rooms}
    patches = [p for p in cut_by_room(surfels, planes, labels, chosen.min_side_surfels) if p.room in known]
    sides = join_patches(patches, surfels, max_angle_deg=chosen.join_angle_deg, max_offset_m=chosen.join_offset_m)
    walls = [side for side in sides if side.vertical]
    looked_at = sorted([*walls, *floor_sides(known)], key=lambda side: side.room)
    reach = {"surface_m": chosen.surface_m, "front_m": chosen.front_m, "inset_m": chosen.max_inset_m}
    views = SideViews(rays, looked_at, surfels, **reach)
    holes, blind = (_bounding(found, known, chosen) for found in _all_holes(views, chosen))
    rays = told_by_sight(rays, surfels, views.unhindered)
    doors = group_holes([hole for hole in holes if hole.side.vertical], rays, known, chosen)
    backs = Walls(walls, surfels, chosen.max_gap_m)
    openings = open_walls(doors, rays, known, neighbours, backs, chosen)
    doorways = [hole for hole in blind if is_doorway(hole, known[hole.side.room].floor_elevation, chosen)]
    hidden = without_rivals(group_holes(doorways, rays, known, chosen), doors, chosen.max_gap_m)
    openings += [way for way in open_walls(hidden, rays, known, neighbours, backs, chosen) if way.kind == "door"]
    lines = contact_sides(surfels, labels, known, openings, chosen)
    found = chain.from_iterable(SideViews(rays, lines, surfels, **reach).each(partial(find_holes, parameters=chosen)))
    framed = [hole for hole in found if hole.bounded[0] and hole.bounded[2]]
    passages = without_rivals(group_holes(framed, rays, known, chosen), doors, chosen.max_gap_m)
    openings += open_walls(passages, rays, known, neighbours, backs, chosen)
    slabs = group_holes([hole for hole in holes if hole.side.horizontal], rays, known, chosen)
    openings += [stairs for group in slabs if (stairs := open_slab(group, rays, known, surfels, chosen)) is not None]
    led = {id(lead.hole) for group in doors for lead in group.leads}
    blind += [hole for hole in holes if hole.side.vertical and id(hole) not in led]
    openings += open_blind(blind, walls, known, openings, surfels, Sight(surfels, rays), chosen)
    return tuple(sorted(with_leaves(openings, surfels), key=_order))


def _all_holes(views: SideViews, parameters: OpeningParameters) -> tuple[list[Hole], list[Hole]]:
    """Find the holes that rays go through in all sides, and the holes of walls whether rays go through or not."""

    def look(view: SideView) -> tuple[list[Hole], list[Hole]]:
        return find_holes(view, parameters), find_blind_holes(view, parameters) if view.side.vertical else []

    found = views.each(look)
    return [hole for holes, _ in found for hole in holes], [hole for _, blind in found for hole in blind]


def _bounding(holes: Iterable[Hole], rooms: Mapping[int, Room], parameters: OpeningParameters) -> list[Hole]:
    """Leave out holes that lie within their room."""
    return [hole for hole in holes if hole.side.horizontal or not within_room(hole, rooms[hole.side.room], parameters)]


def _order(opening: Opening) -> tuple[int, int, tuple[float, ...]]:
    other = opening.room_b if opening.room_b is not None else -1
    return opening.room_a, other, tuple(opening.position.round(3))
