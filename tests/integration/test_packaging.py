"""Wheel and source archive install and run from an empty folder, without the repository beside them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def run(*command: str | Path, cwd: Path, **environment: str) -> str:
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with wheel and source archive, built from a copy so that the repository stays as it is."""
    folder = tmp_path_factory.mktemp("distributions")
    source = folder / "source"
    listed = run("git", "ls-files", "-co", "--exclude-standard", cwd=ROOT).splitlines()
    for name in listed:
        path = ROOT / name
        if path.is_file() and not path.is_symlink():
            target = source / name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(path.read_bytes())
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, source, cwd=folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("pattern", ["*.whl", "*.tar.gz"])
def test_runs_from_an_empty_folder(distributions: Path, tmp_path: Path, pattern: str) -> None:
    site, empty = tmp_path / "site", tmp_path / "empty"
    empty.mkdir()
    (archive,) = distributions.glob(pattern)
    install = (sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation")
    run(*install, "--target", site, archive, cwd=empty)

    where = run(sys.executable, "-c", "import enfilade; print(enfilade.__file__)", cwd=empty, PYTHONPATH=str(site))
    assert Path(where.strip()).is_relative_to(site)
    run(sys.executable, "-m", "enfilade", "simulate", "-o", "d.e57", "--step", "3", cwd=empty, PYTHONPATH=str(site))
    run(sys.executable, "-m", "enfilade", "import", "d.truth", cwd=empty, PYTHONPATH=str(site))
    question = "MATCH (a:Room)-[:DOOR]-(b:Room) RETURN a, b"
    answer = run(
        sys.executable, "-m", "enfilade", "query", question, "--format", "csv", cwd=empty, PYTHONPATH=str(site)
    )
    assert answer.startswith("a,b\n")
    assert len(answer.splitlines()) > 1
    assert not any(path.name in ("ingest", "queries", "schema") for path in site.iterdir())
