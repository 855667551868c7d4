"""How names and texts are written in a question, in both directions."""

from __future__ import annotations

import re
from typing import Final

from .syntax import AGGREGATES

FUNCTIONS: Final = (*AGGREGATES, "like", "object")
"""Every function of the language."""

_PLAIN_NAME: Final = re.compile(r"[^\W\d]\w*")
_NOT_CODE: Final = re.compile(
    r"""('(?:\\.|[^'\\])*'|"(?:\\.|[^"\\])*"|`(?:``|[^`])+`)|(?://[^\n]*|/\*.*?\*/|\s+)+""", re.S
)
_ESCAPE: Final = re.compile(r"\\(u[0-9A-Fa-f]{4}|U[0-9A-Fa-f]{8}|.)", re.S)
_ESCAPED: Final = {"\\": "\\", "'": "'", '"': '"', "`": "`", "b": "\b", "f": "\f", "n": "\n", "r": "\r", "t": "\t"}
_FOLDED_FUNCTIONS: Final = {name.casefold(): name for name in FUNCTIONS}

KEYWORDS: Final = frozenset(
    re.findall(
        r"\w+",
        "match optional where return like within at as order by skip limit per building relax or xor and not starts"
        " ends with contains in is null true false all distinct asc ascending desc descending",
    )
)
"""Words that are read as themselves where a name could stand; such a name is written in backquotes."""


def unquoted(written: str) -> str:
    """Return a name as it is, without its backquotes."""
    return written[1:-1].replace("``", "`") if written.startswith("`") else str(written)


def quoted(name: str) -> str:
    """Return a name as it is written, in backquotes if it needs them."""
    if _PLAIN_NAME.fullmatch(name) and name.casefold() not in KEYWORDS:
        return name
    return "`" + name.replace("`", "``") + "`"


def after_colon(name: str) -> str:
    """Return a label or an edge type as it is written; after the colon a keyword is a name."""
    return name if _PLAIN_NAME.fullmatch(name) else quoted(name)


def function_name(written: str) -> str:
    """Return a function's name as the language spells it, whatever its case."""
    name = unquoted(written)
    return _FOLDED_FUNCTIONS.get(name.casefold(), name)


def text_of(written: str) -> str:
    """Return the text inside quotes, its escapes resolved.

    Raises
    ------
    ValueError
        If an escape is unknown.
    """
    return _ESCAPE.sub(_unescape, written[1:-1])


def text_in_quotes(text: str) -> str:
    """Return a text as it is written in a question."""
    backslashed = {value: f"\\{letter}" for letter, value in _ESCAPED.items() if letter not in '"`'}
    return "'" + "".join(backslashed.get(letter, letter) for letter in text) + "'"


def without_blanks(written: str) -> str:
    """Return a piece of a question with comments left out and every run of blanks as one."""
    return _NOT_CODE.sub(lambda found: found[1] or " ", written).strip()


def _unescape(found: re.Match[str]) -> str:
    escape = found.group(1)
    if len(escape) > 1:
        code = int(escape[1:], 16)
        if code > 0x10FFFF or 0xD800 <= code <= 0xDFFF:
            raise ValueError(f"there is no character \\{escape}")
        return chr(code)
    if escape not in _ESCAPED:
        raise ValueError(f"there is no escape \\{escape}; a backslash is written twice")
    return _ESCAPED[escape]
