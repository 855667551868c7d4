"""What goes wrong inside a parser, said in a sentence that names the file."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from typing import Concatenate, Final, ParamSpec, TypeVar

from enfilade.errors import InputError

P = ParamSpec("P")
T = TypeVar("T")

_SPOILT: Final = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
)
"""What parsers of ours and of libraries raise at bytes that make no sense."""
_LONGEST: Final = 200


def naming_faults(
    form: str, *, native: tuple[type[BaseException], ...] = ()
) -> Callable[[Callable[Concatenate[Path, P], Iterator[T]]], Callable[Concatenate[Path, P], Iterator[T]]]:
    """Decorate a generator of what is in a file: its faults become an InputError that names file and format.

    Parameters
    ----------
    form
        Name of the format.
    native
        Further exceptions of a library, whose first line is worth repeating.
    """
    expected: tuple[type[BaseException], ...] = (*_SPOILT, *native)

    def decorate(parse: Callable[Concatenate[Path, P], Iterator[T]]) -> Callable[Concatenate[Path, P], Iterator[T]]:
        @wraps(parse)
        def guarded(path: Path, /, *args: P.args, **kwargs: P.kwargs) -> Iterator[T]:
            if path.stat().st_size == 0:
                raise InputError(f"{path} is empty (0 bytes): export or copy it again")
            try:
                yield from parse(path, *args, **kwargs)
            except OSError as error:
                raise InputError(f"{path} cannot be read: {error.strerror or error}") from error
            except expected as error:
                raise InputError(
                    f"{path} cannot be read as {form}: {_cause(error)}; export or copy it again"
                ) from error

        return guarded

    return decorate


def _cause(error: BaseException) -> str:
    """First line of what a parser said, or that the file is damaged where it said nothing fit to be read."""
    lines = str(error).strip().splitlines()
    said = lines[0].rstrip(".")[:_LONGEST] if lines else ""
    return said if said and not isinstance(error, (LookupError, AttributeError, UnicodeError)) else "it is damaged"
