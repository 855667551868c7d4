"""Where a building's graph comes from: its files, parameters, software and a hash that tells if they changed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import enfilade

from .parameters import Parameters


def provenance(files: Sequence[Path], tables: Sequence[Path], parameters: Parameters) -> dict[str, Any]:
    """Return the properties of a building's node that say what it was made from."""
    resolved = asdict(parameters)
    return {
        "source_files": [file.name for file in files],
        "ingested_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "parameters": resolved,
        "software_version": enfilade.__version__,
        "content_hash": content_hash(files, tables, resolved),
    }


def content_hash(files: Sequence[Path], tables: Sequence[Path], parameters: dict[str, Any]) -> str:
    """SHA-256 of the scan files, the tables of the user and the parameters, in hexadecimal."""
    whole = hashlib.sha256(json.dumps(parameters, sort_keys=True).encode())
    for file in [*files, *tables]:
        with file.open("rb") as stream:
            whole.update(hashlib.file_digest(stream, "sha256").digest())
    return whole.hexdigest()
