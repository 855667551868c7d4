"""Runs the usual chain of Open3D on scans and prints, as JSON, what each step took; a child of ``bench/ingest.py``.

``python bench/open3d_chain.py SCANS...``: 2 cm voxels, normals, planar patches, clusters of what lies on none.
Reading is left out.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any, Final

import numpy as np
from measured_ingest import cpu_seconds, peak_gb
from rewritten_scans import points_of

from enfilade.ingest.readers import read_scans
from enfilade.native import open3d

VOXEL_M: Final = 0.02
RADIUS_M: Final = 0.1
NEIGHBOURS: Final = 30
CLUSTER_M: Final = 0.05
LEAST_POINTS: Final = 10


def main(scans: list[Path]) -> None:
    """Read, run the chain, print its seconds."""
    o3d = open3d()
    points = np.concatenate([points_of(scan) for scan in read_scans(scans)])
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    count = len(points)
    del points
    steps: list[dict[str, Any]] = []

    def timed(name: str, start: tuple[float, float]) -> tuple[float, float]:
        now = (time.perf_counter(), cpu_seconds())
        steps.append({"step": name, "wall_s": now[0] - start[0], "cpu_s": now[1] - start[1]})
        return now

    moment = (time.perf_counter(), cpu_seconds())
    cloud = cloud.voxel_down_sample(VOXEL_M)
    moment = timed("voxel_down_sample", moment)
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(RADIUS_M, NEIGHBOURS))
    moment = timed("estimate_normals", moment)
    patches = cloud.detect_planar_patches()
    moment = timed("detect_planar_patches", moment)
    on_patch = [index for patch in patches for index in patch.get_point_indices_within_bounding_box(cloud.points)]
    rest = cloud.select_by_index(on_patch, invert=True)
    rest.cluster_dbscan(CLUSTER_M, LEAST_POINTS)
    timed("cluster_dbscan", moment)
    print(json.dumps({"points": count, "down_sampled": len(cloud.points), "steps": steps, "peak_gb": peak_gb()}))


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
