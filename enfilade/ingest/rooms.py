"""Rooms by label diffusion (§4, Eqs. 1-6): points that see each other tend to share a room.

Surfels are gathered into nodes: the cells of a planar patch, or voxels where there is no plane. Rays from each node
are traced once; what they hit is kept as the row-stochastic matrix T of Eq. 1, and each iteration of Eq. 3 is a
product with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from enfilade.progress import Progress, Silent

from .cells import CellGrid
from .records import F32, F64, I32, Groups, Planes, RoomLabels, Surfels
from .structure import Structure

I64 = NDArray[np.int64]
_SILENT: Final = Silent()
_RAYS_AT_ONCE: Final = 1 << 20
_ROOMS_AT_ONCE: Final = 16
_LIFT_M: Final = 0.03
_GOLDEN: Final = (np.sqrt(5.0) - 1.0) / 2.0


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
    key = np.empty(len(surfels.positions), np.int64)
    on_plane = planes.surfel_plane >= 0
    key[on_plane] = _cell_keys(
        surfels.positions[on_plane], planes.surfel_plane[on_plane], planes, first_key, shapes[:, 1], node_m
    )
    if not on_plane.all():
        loose = surfels.positions[~on_plane]
        key[~on_plane] = first_key[-1] + CellGrid.around(loose, node_m).keys(loose)
    members = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[members], prepend=-1))
    of_surfel = np.empty(len(key), np.int32)
    of_surfel[members] = np.repeat(np.arange(len(starts), dtype=np.int32), np.diff(starts, append=len(key)))
    return Nodes(of_surfel, members, np.append(starts, len(key)), key[members[starts]], first_key, shapes[:, 1])


def _node_shape(cells: tuple[int, ...], cell_m: float, node_m: float) -> tuple[int, int]:
    rows, columns = (int(np.ceil(count * cell_m / node_m)) + 1 for count in cells)
    return rows, columns


def _cell_keys(positions: F32, plane: I32, planes: Planes, first_key: I64, columns: I64, node_m: float) -> I64:
    """Key of the cell of its plane that each position projects to."""
    corner = np.array([b.origin for b in planes.bitmaps])[plane]
    relative = positions - corner
    j = np.einsum("ij,ij->i", relative, np.array([b.u for b in planes.bitmaps])[plane]) / node_m
    i = np.einsum("ij,ij->i", relative, np.array([b.v for b in planes.bitmaps])[plane]) / node_m
    i, j = np.maximum(np.floor(i), 0).astype(np.int64), np.maximum(np.floor(j), 0).astype(np.int64)
    return np.asarray(first_key[plane] + i * columns[plane] + j)


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
    for node, origins, directions in _rays(starts, normals, nodes, parameters.rays):
        hits = structure.cast(origins, directions)
        hit = np.flatnonzero(hits.front)
        points = origins[hit] + hits.distance[hit, None] * directions[hit]
        keys = _cell_keys(points, hits.plane[hit], planes, nodes.first_key, nodes.columns, parameters.node_m)
        target = np.minimum(np.searchsorted(nodes.keys, keys), len(nodes) - 1).astype(np.int32)
        known = nodes.keys[target] == keys
        rows.append(node[hit[known]])
        columns.append(target[known])
        progress.advance(len(node) / max(1, len(nodes) * parameters.rays))
    row, column = np.concatenate(rows), np.concatenate(columns)
    weight = (1.0 / np.bincount(row, minlength=len(nodes)))[row].astype(np.float32)
    return sparse.csr_array((weight, (row, column)), shape=(len(nodes), len(nodes)))


def _rays(starts: F32, normals: F32, nodes: Nodes, count: int) -> Iterator[tuple[I32, F32, F32]]:
    """Yield batches of rays: their nodes, origins and unit directions, `count` for each node.

    A node's rays start at its surfels in turn and spread over the hemisphere of the surfel's normal.
    """
    batch = max(1, _RAYS_AT_ONCE // count)
    fan = _hemisphere(count)
    for first in range(0, len(nodes), batch):
        node = np.arange(first, min(first + batch, len(nodes)), dtype=np.int32)
        size = np.diff(nodes.starts[first : first + len(node) + 1])
        step = np.arange(count)[None, :] * size[:, None] // count
        member = nodes.members[(nodes.starts[node][:, None] + step).ravel()]
        spun = _spun(fan, node)
        yield np.repeat(node, count), starts[member], _turned(spun, normals[member])


def ray_starts(surfels: Surfels, planes: Planes) -> tuple[F32, F32]:
    """Where the rays of each surfel start, a little above its plane or itself, and around which normal."""
    lift = np.full(len(surfels.positions), _LIFT_M, np.float32)
    normals = surfels.normals.copy()
    on_plane = planes.surfel_plane >= 0
    plane = planes.surfel_plane[on_plane]
    normals[on_plane] = planes.normals[plane]
    height = np.einsum("ij,ij->i", surfels.positions[on_plane], planes.normals[plane]) - planes.offsets[plane]
    lift[on_plane] -= height
    return surfels.positions + lift[:, None] * normals, normals


def _hemisphere(count: int) -> F64:
    """``(count, 2)`` azimuth and height of directions spread evenly over the hemisphere (a Fibonacci lattice)."""
    step = np.arange(count)
    return np.stack([2.0 * np.pi * _GOLDEN * step, (step + 0.5) / count], axis=1)


def _spun(fan: F64, node: I32) -> F32:
    """Turn the fan about the normal and shift it in height, by a low-discrepancy amount a node: ``(n count, 3)``."""
    count = len(fan)
    azimuth = fan[None, :, 0] + 2.0 * np.pi * (_GOLDEN * node[:, None] % 1.0)
    shift = (node[:, None] * np.sqrt(2.0)) % 1.0 - 0.5
    height = np.clip(fan[None, :, 1] + shift / count, 1e-3, 1.0)
    flat = np.sqrt(1.0 - height**2)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), height], axis=2).reshape(-1, 3).astype(np.float32)


def _turned(directions: F32, normals: F32) -> F32:
    """Directions given around +z, turned to be around the normals (the frame of Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.where(z >= 0.0, np.float32(1.0), np.float32(-1.0))
    a = -1.0 / (sign + z)
    b = x * y * a
    u = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    v = np.stack([b, sign + y * y * a, -y], axis=1)
    turned = directions[:, :1] * u + directions[:, 1:2] * v + directions[:, 2:] * normals
    return np.asarray(turned, np.float32)


# --- diffusion -------------------------------------------------------------------------------------------------


def _viewers(
    structure: Structure, starts: F32, normals: F32, groups: Groups, parameters: RoomParameters
) -> sparse.csr_array:
    """``(nodes, S)``: 1 where the viewpoint of a scan that votes, or stood outside, sees a node from its front."""
    voting = np.flatnonzero(groups.votes | (groups.scan_room < 0))
    viewpoints = groups.viewpoints[voting]
    count = min(parameters.viewpoints, len(voting))
    nearest = cKDTree(viewpoints).query(starts, k=count, distance_upper_bound=parameters.view_m)[1]
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
