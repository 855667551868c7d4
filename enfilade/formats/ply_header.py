"""The header of a PLY file: which elements follow, in which form."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

from enfilade.errors import InputError

_LONGEST_HEADER: Final = 400
_LONGEST_LINE: Final = 500
_TYPES: Final = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float": "f4",
    "double": "f8",
    "float32": "f4",
    "float64": "f8",
}


@dataclass(frozen=True, slots=True)
class Element:
    """One kind of things in the file.

    Attributes
    ----------
    name
        ``vertex``, ``face``, ...
    count
        How many there are.
    properties
        Name and numpy type (without byte order) of each number of such a thing.
    is_plain
        Whether these are all it has: no lists, no unknown types, no name twice.
    """

    name: str
    count: int
    properties: tuple[tuple[str, str], ...]
    is_plain: bool


@dataclass(frozen=True, slots=True)
class PlyHeader:
    """What the header says.

    Attributes
    ----------
    form
        ``ascii``, ``binary_little_endian`` or ``binary_big_endian``.
    elements
        In the order of the file.
    comments
        Their texts.
    start
        Where the things begin, bytes.
    """

    form: str
    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    start: int


def read_ply_header(file: BinaryIO, path: Path) -> PlyHeader:
    """Read the header of an opened PLY file.

    Raises
    ------
    InputError
        The file does not begin as PLY does, or its header has no end.
    """
    if file.read(4).rstrip() != b"ply":
        raise InputError(f"{path} does not begin as a PLY file does: it is damaged, or no PLY file.")
    lines: list[str] = []
    while len(lines) < _LONGEST_HEADER:
        line = file.readline(_LONGEST_LINE)
        lines.append(line.decode("ascii", errors="replace").strip())
        if lines[-1] == "end_header":
            return _parse(lines, file.tell())
        if not line:
            break
    raise InputError(f"{path} is truncated or damaged: its header has no end; export or ingest it again.")


def _parse(lines: list[str], start: int) -> PlyHeader:
    form, comments, blocks = "", [], []
    for line in lines:
        words = line.split()
        if words[:1] == ["format"]:
            form = words[1] if len(words) > 1 else ""
        elif words[:1] == ["comment"]:
            comments.append(line.removeprefix("comment").strip())
        elif words[:1] == ["element"]:
            blocks.append([words])
        elif words[:1] == ["property"] and blocks:
            blocks[-1].append(words)
    return PlyHeader(form, tuple(_element(block) for block in blocks), tuple(comments), start)


def _element(block: list[list[str]]) -> Element:
    """Return an element; a count that is none is -1."""
    (_, *named), *properties = block
    name, count = (named[0], named[1]) if len(named) == 2 else ("", "")
    plain = tuple((words[2], _TYPES[words[1]]) for words in properties if len(words) == 3 and words[1] in _TYPES)
    is_plain = len(plain) == len(properties) and len({name for name, _ in plain}) == len(plain)
    return Element(name, int(count) if count.isdecimal() else -1, plain, is_plain)
