"""Where the scanners stood: what the files say, and what the user says of files that do not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from enfilade.errors import InputError
from enfilade.ingest.records import F64

from .positions import PositionTable
from .trajectory import Trajectory

_FARTHEST: Final = 1e9


@dataclass(slots=True)
class Whereabouts:
    """Tells the position of each scan, in file units.

    Parameters
    ----------
    table
        Positions from the user's table; they go before those of the files.
    trajectory
        The way of a moving scanner.
    say
        Hears what the user should know.
    """

    table: PositionTable | None = None
    trajectory: Trajectory | None = None
    say: Callable[[str], None] = lambda sentence: None
    _at_origin: list[str] = field(default_factory=list)

    def scanner(self, path: Path, name: str, own: F64 | None, *, is_default: bool = False) -> F64:
        """Return where the scanner of a scan stood.

        Parameters
        ----------
        path, name
            File and name of the scan.
        own
            Position in the file, ``(3,)``, or None.
        is_default
            Whether the file's pose is the one that is written when none is known: at the origin, unturned. One scan
            may stand there, the others being registered to it; several cannot.

        Raises
        ------
        InputError
            Nothing tells the position, or a second scan stands at the origin.
        """
        what = f"scan {name!r} of {path}"
        given = self.table.find(path, name) if self.table is not None else None
        if given is not None:
            return given
        if own is None:
            raise InputError(
                f"no scanner position in {what}: export the scans registered, with their positions, or give a table "
                "of them with --positions"
            )
        if not np.isfinite(own).all() or np.abs(own).max() > _FARTHEST:
            raise InputError(f"the scanner position in {what} is not a usable number: export the scans again")
        if is_default:
            self._at_origin.append(what)
            self._refuse_second_at_origin()
        return own

    def _refuse_second_at_origin(self) -> None:
        if len(self._at_origin) > 1:
            raise InputError(
                f"{self._at_origin[0]} and {self._at_origin[1]} both stand at the origin, as exports write it when "
                "the positions are lost: export the scans registered, or give their positions with --positions"
            )
