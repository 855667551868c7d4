"""Finds the name that somebody probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name most like `name`, whatever its case, or None where none is near."""
    folded = {k.casefold(): k for k in known}
    found = get_close_matches(name.casefold(), folded, n=1, cutoff=0.5)
    return folded[found[0]] if found else None


def hint(name: str, known: Iterable[str]) -> str:
    """Return the end of an error's sentence: the nearest known name, or all of them."""
    names = tuple(known)
    found = nearest(name, names)
    return f'did you mean "{found}"?' if found else f"known are {', '.join(names)}"
