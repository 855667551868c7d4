"""Rooms by label diffusion (§4, Eqs. 1-6): points that see each other tend to share a room.

Surfels are gathered into nodes: the cells of a planar patch, or voxels where there is no plane. Rays from each node
are traced once; what they hit is kept as the row-stochastic matrix T of Eq. 1, and each iteration of Eq. 3 is a
product with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from enfilade.parallel import at_once, slices
from enfilade.progress import Progress, Silent

from .cells import CellGrid, Gathered
from .fans import fans
from .records import F32, F64, I32, Groups, Planes, RoomLabels, Surfels
from .structure import Structure

I64 = NDArray[np.int64]
_SILENT: Final = Silent()
_RAYS_AT_ONCE: Final = 1 << 20
_ROOMS_AT_ONCE: Final = 16
_LIFT_M: Final = 0.03


@dataclass(frozen=True, slots=True)
class RoomParameters:
    """How labels diffuse.

    Attributes
    ----------
    node_m
        Side of the cells that share one label distribution.
    rays
        Sample rays from each of them.
    viewpoints
        Nearest viewpoints that are asked whether they see a node.
    view_m
        How far a viewpoint sees.
    close_doors_m
        Openings under a lintel up to this height do not let rays pass; 0 lets them, as in the paper.
    below_floor_m
        What lies further below the floor of a room than this is not of the room.
    iterations
        N of Eq. 5: how many iterations are summed.
    least_surfels
        A room left with fewer is joined to the one that took its surfels: its scans stood in a doorway, say.
    """

    node_m: float = 0.20
    rays: int = 24
    viewpoints: int = 12
    view_m: float = 25.0
    close_doors_m: float = 2.4
    below_floor_m: float = 0.5
    iterations: int = 2
    least_surfels: int = 1600


@dataclass(frozen=True, slots=True)
class Nodes:
    """Surfels gathered: node n has ``members[starts[n]:starts[n + 1]]``.

    Attributes
    ----------
    of_surfel
        ``(M,) int32`` node of each surfel.
    members
        ``(M,) int64`` surfels ordered by node.
    starts
        ``(n + 1,) int64``.
    keys
        ``(n,) int64``, sorted.
    first_key
        ``(P + 1,) int64`` key of the first cell of each plane; what is on no plane comes after the last.
    columns
        ``(P,) int64`` cells in a row of each plane.
    """

    of_surfel: I32
    members: I64
    starts: I64
    keys: I64
    first_key: I64
    columns: I64

    def __len__(self) -> int:
        return len(self.keys)


def label_rooms(
    surfels: Surfels,
    planes: Planes,
    groups: Groups,
    parameters: RoomParameters = RoomParameters(),
    *,
    progress: Progress = _SILENT,
) -> RoomLabels:
    """Give each surfel the room that the surfels in its sight agree on.

    The paper starts from the room of the scan that measured a point. That is `RoomLabels.before`; the diffusion
    itself starts from the rooms of all the viewpoints that see a node, which are under the ceiling and so look
    into the next room much less than the scanners did.
    """
    structure = Structure(planes, close_doors_m=parameters.close_doors_m)
    nodes = gather_nodes(surfels, planes, parameters.node_m)
    starts, normals = ray_starts(surfels, planes)
    middles = nodes.members[(nodes.starts[:-1] + nodes.starts[1:]) // 2]
    viewers = _viewers(structure, starts[middles], normals[middles], groups, parameters)
    transition = trace_transitions(structure, starts, normals, planes, nodes, parameters, progress=progress)
    scan_room = groups.scan_room
    heights = starts[middles, 2] + parameters.below_floor_m
    while True:
        before = scan_room[surfels.scan]
        count = int(scan_room.max()) + 1
        # The last label is no room, but the outside.
        label_of_scan = np.where(scan_room < 0, count, scan_room)
        allowed_from = _lowest_floors(groups.floors, scan_room)
        initial = _initial_labels(viewers, label_of_scan, count)
        label, agreement = _diffuse(transition, initial, heights, allowed_from, parameters.iterations)
        after = label[nodes.of_surfel]
        after = np.where(after >= 0, after, before).astype(np.int32)
        after[after == count] = -1
        size = np.bincount(after[after >= 0], minlength=count)
        lost = np.flatnonzero(size < parameters.least_surfels)
        if len(lost) in (0, len(size)):
            return RoomLabels(before, after, agreement[nodes.of_surfel], scan_room, len(size))
        scan_room = _absorbed(scan_room, before, after, lost[np.argmin(size[lost])])


def _absorbed(scan_room: I32, before: I32, after: I32, lost: np.intp) -> I32:
    """Rooms of the scans after a room that lost nearly all its surfels is joined to the one that got most of them."""
    winners = np.bincount(after[(before == lost) & (after >= 0)], minlength=int(scan_room.max()) + 1)
    winners[lost] = -1
    winner = np.argmax(winners) if winners.max() > 0 else -1
    joined = np.where(scan_room == lost, winner, scan_room)
    return (joined - (joined > lost)).astype(np.int32)


def gather_nodes(surfels: Surfels, planes: Planes, node_m: float) -> Nodes:
    """Gather surfels into the cells of their plane, or into voxels where they lie on none."""
    shapes = np.array([_node_shape(b.occupancy.shape, b.cell_m, node_m) for b in planes.bitmaps], np.int64)
    shapes = shapes.reshape(-1, 2)
    first_key = np.concatenate([[0], np.cumsum(shapes[:, 0] * shapes[:, 1])])
    key = _cell_keys(surfels.positions, planes.surfel_plane, planes, first_key, shapes[:, 1], node_m)
    loose = np.flatnonzero(key < 0)
    if len(loose):
        positions = surfels.positions[loose]
        key[loose] = first_key[-1] + CellGrid.around(positions, node_m).keys(positions)
    gathered = Gathered.by(key)
    of_surfel = np.empty(len(key), np.int32)
    of_surfel[gathered.order] = np.repeat(np.arange(len(gathered), dtype=np.int32), np.diff(gathered.bounds))
    return Nodes(of_surfel, gathered.order, gathered.bounds, gathered.keys, first_key, shapes[:, 1])


def _node_shape(cells: tuple[int, ...], cell_m: float, node_m: float) -> tuple[int, int]:
    rows, columns = (int(np.ceil(count * cell_m / node_m)) + 1 for count in cells)
    return rows, columns


def _cell_keys(positions: F32, plane: I32, planes: Planes, first_key: I64, columns: I64, node_m: float) -> I64:
    """Key of the cell of its plane that each position projects to, -1 for those on none."""
    frames = np.array([(b.origin, b.u, b.v) for b in planes.bitmaps], np.float64).reshape(-1, 3, 3)
    return np.asarray(_project(positions, plane, frames, first_key, columns, node_m), np.int64)


@njit(cache=True, nogil=True)
def _project(positions: F32, plane: I32, frames: F64, first_key: I64, columns: I64, node_m: float) -> I64:
    keys = np.full(len(plane), -1, np.int64)
    for at in range(len(plane)):
        p = plane[at]
        if p >= 0:
            along, up = 0.0, 0.0
            for axis in range(3):
                relative = positions[at, axis] - frames[p, 0, axis]
                along += relative * frames[p, 1, axis]
                up += relative * frames[p, 2, axis]
            row, column = max(0, int(np.floor(up / node_m))), max(0, int(np.floor(along / node_m)))
            keys[at] = first_key[p] + row * columns[p] + column
    return keys


# --- rays ------------------------------------------------------------------------------------------------------


def trace_transitions(
    structure: Structure,
    starts: F32,
    normals: F32,
    planes: Planes,
    nodes: Nodes,
    parameters: RoomParameters,
    *,
    progress: Progress = _SILENT,
) -> sparse.csr_array:
    """Trace the rays of all nodes and return T (Eq. 1), row-stochastic, one row and column a node."""
    rows, columns = [np.arange(len(nodes), dtype=np.int32)], [np.arange(len(nodes), dtype=np.int32)]
    node_at = np.full(nodes.first_key[-1] + 1, -1, np.int32)
    on_plane = np.flatnonzero(nodes.keys < nodes.first_key[-1])
    node_at[nodes.keys[on_plane]] = on_plane
    count, batch = parameters.rays, max(1, _RAYS_AT_ONCE // parameters.rays)
    for first in range(0, len(nodes), batch):
        past = min(first + batch, len(nodes))
        rays = fans(first, past, count, nodes.members, nodes.starts, starts, normals)
        hits = structure.cast(rays[:, :3], rays[:, 3:])
        hit = np.flatnonzero(hits.front)
        points = rays[hit, :3] + hits.distance[hit, None] * rays[hit, 3:]
        target = node_at[_cell_keys(points, hits.plane[hit], planes, nodes.first_key, nodes.columns, parameters.node_m)]
        known = target >= 0
        rows.append((first + hit[known] // count).astype(np.int32))
        columns.append(target[known])
        progress.advance((past - first) / len(nodes))
    row, column = np.concatenate(rows), np.concatenate(columns)
    weight = (1.0 / np.bincount(row, minlength=len(nodes)))[row].astype(np.float32)
    return sparse.csr_array((weight, (row, column)), shape=(len(nodes), len(nodes)))


def ray_starts(surfels: Surfels, planes: Planes) -> tuple[F32, F32]:
    """Where the rays of each surfel start, a little above its plane or itself, and around which normal."""
    starts, normals = np.empty_like(surfels.positions), surfels.normals.copy()

    def fill(first: int, past: int) -> None:
        some = slice(first, past)
        positions, plane_of, normal = surfels.positions[some], planes.surfel_plane[some], normals[some]
        lift = np.full(past - first, _LIFT_M, np.float32)
        on_plane = plane_of >= 0
        plane = plane_of[on_plane]
        normal[on_plane] = planes.normals[plane]
        lift[on_plane] -= np.einsum("ij,ij->i", positions[on_plane], planes.normals[plane]) - planes.offsets[plane]
        starts[some] = positions + lift[:, None] * normal

    at_once(fill, slices(len(starts)))
    return starts, normals


# --- diffusion -------------------------------------------------------------------------------------------------


def _viewers(
    structure: Structure, starts: F32, normals: F32, groups: Groups, parameters: RoomParameters
) -> sparse.csr_array:
    """``(nodes, S)``: 1 where the viewpoint of a scan that votes, or stood outside, sees a node from its front."""
    voting = np.flatnonzero(groups.votes | (groups.scan_room < 0))
    viewpoints = groups.viewpoints[voting]
    count = min(parameters.viewpoints, len(voting))
    nearest = cKDTree(viewpoints).query(starts, k=count, distance_upper_bound=parameters.view_m, workers=-1)[1]
    node, rank = np.nonzero(nearest.reshape(len(starts), count) < len(voting))
    viewer = nearest.reshape(len(starts), count)[node, rank]
    in_front = np.einsum("ij,ij->i", viewpoints[viewer] - starts[node], normals[node]) > 0.0
    node, viewer = node[in_front], viewer[in_front]
    sees = ~structure.blocked(starts[node], viewpoints[viewer])
    ones = np.ones(int(sees.sum()), np.float32)
    shape = (len(starts), len(groups.votes))
    return sparse.csr_array((ones, (node[sees], voting[viewer[sees]])), shape=shape)


def _lowest_floors(floors: F32, scan_room: I32) -> F32:
    """``(R + 1,)`` the lowest floor under a scanner of each room; there is none for the outside."""
    lowest = np.full(int(scan_room.max()) + 2, np.inf, np.float32)
    inside = scan_room >= 0
    np.minimum.at(lowest, scan_room[inside], floors[inside])
    lowest[-1] = -np.inf
    return lowest


def _diffuse(
    transition: sparse.csr_array, initial: sparse.csc_array, heights: F32, floors: F32, iterations: int
) -> tuple[I32, F32]:
    """Label of each node by Eq. 5, from L_0, and the label's share of the sum; rooms are taken a few at a time.

    What lies below a room's floor is not of the room, however well it is seen from a gallery or down the stairs.
    """
    count = transition.shape[0]
    best, total = np.zeros(count, np.float32), np.zeros(count, np.float32)
    label = np.full(count, -1, np.int32)
    for first in range(0, initial.shape[1], _ROOMS_AT_ONCE):
        some = slice(first, first + _ROOMS_AT_ONCE)
        above_floor = heights[:, None] >= floors[None, some]
        current = initial[:, some].toarray() * above_floor
        summed = np.zeros_like(current)
        for _ in range(iterations):
            current = (transition @ current) * above_floor
            summed += current
        winner = np.argmax(summed, axis=1)
        value = summed[np.arange(count), winner]
        better = value > best
        label[better] = first + winner[better]
        best[better] = value[better]
        total += summed.sum(axis=1)
    return label, np.divide(best, total, out=np.zeros_like(best), where=total > 0.0)


def _initial_labels(viewers: sparse.csr_array, label_of_scan: I64, outside: int) -> sparse.csc_array:
    """L_0 (Eq. 2): the share of each room among the viewpoints that see a node.

    Scans outside say `outside` where no scan inside looks: through windows they see rooms, too.
    """
    scans = np.arange(len(label_of_scan))
    ones = np.ones(len(scans), np.float32)
    rooms = sparse.csr_array((ones, (scans, label_of_scan)), shape=(len(scans), outside + 1))
    seen = sparse.coo_array(viewers @ rooms)
    node, label = seen.coords
    total = np.bincount(node[label < outside], seen.data[label < outside], minlength=viewers.shape[0])
    counts = (label < outside) | (total[node] == 0)
    node, label, votes = node[counts], label[counts], seen.data[counts]
    share = votes / np.bincount(node, votes, minlength=viewers.shape[0])[node]
    return sparse.csc_array((share.astype(np.float32), (node, label)), shape=seen.shape)
