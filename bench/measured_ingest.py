"""Ingests scans into a store of its own and prints, as JSON, what each stage took; a child of ``bench/ingest.py``.

``python bench/measured_ingest.py FOLDER TIMES SCANS...``: the graph and the cloud go into FOLDER. With TIMES above 1
the scans are read so often, with new noise each time but the first; making it counts as reading.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final
from unittest.mock import patch

import psutil

ANEW: Final = "5"
"""What Linux's ``clear_refs`` takes to begin the process's peak of memory anew."""


class Meter:
    """Hears of stages and notes what each took; the first is the start of the process with its imports."""

    def __init__(self) -> None:
        self.stages: list[dict[str, Any]] = []
        self._stage, self._wall, self._cpu = "start", psutil.Process().create_time(), 0.0

    def start(self, stage: str, total: float | None = None) -> None:
        """End the stage before and begin one."""
        wall, cpu = time.time(), cpu_seconds()
        spent = {"wall_s": wall - self._wall, "cpu_s": cpu - self._cpu, "peak_gb": peak_gb()}
        self.stages.append({"stage": self._stage, **spent})
        self._stage, self._wall, self._cpu = stage, wall, cpu

    def advance(self, amount: float = 1.0) -> None:
        """Ignore it."""

    def note(self, sentence: str) -> None:
        """Ignore it."""


def cpu_seconds() -> float:
    """User and system time of this process, all its threads, and its children that have ended."""
    return sum(os.times()[:4])


def peak_gb() -> float:
    """Most memory held since the last call, in GB; since the start of the process where the system cannot tell."""
    status, clear = Path("/proc/self/status"), Path("/proc/self/clear_refs")
    if not clear.exists():
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e9 if sys.platform == "darwin" else 1e6)
    line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
    clear.write_text(ANEW)
    return int(line.split()[1]) * 1024 / 1e9


def main(folder: Path, times: int, scans: list[Path]) -> None:
    """Ingest as the command does, and print what it took."""
    meter = Meter()
    from enfilade.ingest import pipeline
    from enfilade.ingest.readers import read_scans
    from enfilade.stores.archive import Archive
    from enfilade.stores.sqlite import SQLiteStore

    def reading(*sources: Any, **options: Any) -> Iterator[Any]:
        from rewritten_scans import scanned_again

        yield from read_scans(*sources, **options)
        for again in range(1, times):
            yield from scanned_again(read_scans(*sources, **options), again)

    with patch.object(pipeline, "read_scans", reading if times > 1 else read_scans):
        result = pipeline.ingest(scans, building="measured", progress=meter)
    meter.start("store")
    with SQLiteStore(folder / "measured.db") as store:
        Archive(store, folder / "measured.clouds").save(result.graph, result.cloud)
    meter.start("end")
    building = result.graph.nodes["measured"].properties
    labels = Counter(node.label for node in result.graph.nodes.values())
    size = {"points": building["point_count"], "thinned": len(result.cloud), "scans": building["scan_count"]}
    found = {"rooms": labels["Room"], "openings": labels["Opening"], "objects": labels["Object"]}
    print(json.dumps({**size, **found, "stages": meter.stages}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), [Path(name) for name in sys.argv[3:]])
