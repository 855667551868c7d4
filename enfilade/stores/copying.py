"""Buildings from one store to another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from enfilade.progress import Progress, Silent
from enfilade.stores.base import Store

_SILENT: Final = Silent()


def copy(
    source: Store, target: Store, buildings: Sequence[str] | None = None, *, progress: Progress = _SILENT
) -> list[str]:
    """Copy buildings, each in one transaction; one that is there already is replaced.

    Parameters
    ----------
    source, target
        From where and to where.
    buildings
        Ids, or None for all.
    progress
        Hears of each building.

    Returns
    -------
    list of str
        The ids copied, in order.

    Raises
    ------
    NotFoundError
        If the source has no such building.
    """
    ids = [summary.id for summary in source.buildings()] if buildings is None else list(buildings)
    progress.start("copy", len(ids))
    for id in ids:
        target.write(source.read(id))
        progress.advance()
    return ids
