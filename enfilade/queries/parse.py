"""From text to the query graph; the first fault is shown with its line, column and a caret."""

from __future__ import annotations

import re
from functools import cache
from importlib import resources
from typing import Final

from lark import Lark, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from enfilade.errors import QuestionError
from enfilade.schema.names import nearest

from .graph_builder import Builder
from .query_graph import QueryGraph

_NOT_THERE: Final = {
    "WITH": "WITH is not there; use EXISTS { }, count { } or aggregates in RETURN instead",
    "UNION": "UNION is not there; ask two questions, or use OR and alternatives such as -[:DOOR|PASSAGE]-",
    "CALL": "CALL is not there; use EXISTS { } or count { } instead",
    "CASE": "CASE is not there; return the properties and decide outside",
    "UNWIND": "UNWIND is not there; use IN and a list instead",
    "FOREACH": "FOREACH is not there: a question only reads; use the command ingest or import to change a store",
    "EXPLAIN": "EXPLAIN is not there; use the option --explain, or the result's explanation",
    "PROFILE": "PROFILE is not there; use the option --explain, or the result's explanation",
    "USE": "USE is not there; choose the store with --store",
    "=~": "=~ is not there; use STARTS WITH, ENDS WITH or CONTAINS instead",
} | {
    word: f"{word} is not there: a question only reads; use the command ingest, import or remove to change a store"
    for word in ("CREATE", "MERGE", "DELETE", "DETACH", "SET", "REMOVE", "DROP", "LOAD", "INSERT")
}

_READABLE: Final = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a text in quotes",
    "PARAMETER": "a $parameter",
    "COMPARISON": "a comparison",
    "ARROW_LEFT": '"<-"',
    "ARROW_RIGHT": '"->"',
    "EQUALS": '"="',
    "ASCENDING": "ASC",
    "DESCENDING": "DESC",
    "LPAR": '"("',
    "RPAR": '")"',
    "LSQB": '"["',
    "RSQB": '"]"',
    "LBRACE": '"{"',
    "RBRACE": '"}"',
    "COMMA": '","',
    "COLON": '":"',
    "DOT": '"."',
    "MINUS": '"-"',
    "VBAR": '"|"',
    "STAR": '"*"',
    "$END": "the end",
    "__ANON_0": '".."',
}
_UNTOLD: Final = frozenset({"SEMICOLON", "PLUS", "SLASH", "PERCENT", "CIRCUMFLEX", "PARAMETER", "STRING"})
"""Terminals that may stand almost anywhere: to name them tells nothing."""

_BEHIND_RETURN: Final = ("ORDER", "SKIP", "LIMIT", "PER", "RELAX")

NESTED: Final = "the question is nested too deeply; make it simpler."

_MOST_TOLD: Final = 6

_CLAUSE_BEFORE: Final = re.compile(r"\b(return|match|where|order|limit|skip)\s+\Z", re.I)
_STARTED: Final = re.compile(r"(?:[\w)}\]'\"`]\s*\Z)", re.I)
"""How the text before a clause ends if that text is complete."""


def parse(text: str) -> QueryGraph:
    """Read a question.

    Raises
    ------
    QuestionError
        If the text is no question of the language; with line and column.
    """
    try:
        return Builder(text).question(parser().parse(text))
    except UnexpectedInput as error:
        raise _explained(error, text) from None
    except RecursionError:
        raise QuestionError(NESTED) from None


@cache
def parser() -> Lark:
    """Return the parser of the language; it is made once."""
    grammar = resources.files(__package__).joinpath("language.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", start="question", propagate_positions=True)


def is_unfinished(text: str) -> bool:
    """Whether a text is the beginning of a question, and not yet a whole one."""
    try:
        parser().parse(text)
    except UnexpectedToken as error:
        return bool(error.token.type == "$END")
    except UnexpectedCharacters as error:
        return text.startswith(("'", '"', "`"), error.pos_in_stream)
    return False


def _explained(error: UnexpectedInput, text: str) -> QuestionError:
    word = _word_at(error, text)
    clause = _CLAUSE_BEFORE.search(text, 0, error.pos_in_stream or 0) if word else None
    if clause is not None and not _STARTED.search(text, 0, clause.start()):
        message = f'"{clause[1]}" is not understood here; a value is missing before it.'
        return QuestionError(message, text=text, **_place_of(text, clause.start(1)))
    position = len(text.rstrip()) if word == "" else (error.pos_in_stream or 0) - (word == "=~")
    return QuestionError(_sentence(error, word, text), text=text, **_place_of(text, position))


def _sentence(error: UnexpectedInput, word: str, text: str) -> str:
    gone = next((found for found in _suspects(error, word, text) if found in _NOT_THERE), None)
    if gone is not None:
        return f"{_NOT_THERE[gone]}."
    expected = _expected(error)
    keywords = [name for name in expected if name.isupper()]
    meant = nearest(word, keywords) if len(word) > 1 and word.isalpha() else None
    if meant is not None:
        return f'"{word}" is not understood here; did you mean {meant}?'
    found = f'"{word}" is not understood here' if word else "the question ends too early"
    advice = _advice(error, word)
    if advice:
        return f"{found}; {advice}."
    told = [name for name in expected if name]
    return f"{found}; expected {_listed(told)}."


def _suspects(error: UnexpectedInput, word: str, text: str) -> list[str]:
    """Return the word that is wrong and the one before it, in capitals: CASE is read as a name, WHEN is not."""
    before = text[: error.pos_in_stream or 0].split()
    return [word.upper(), *(part.upper() for part in before[-1:])]


def _advice(error: UnexpectedInput, word: str) -> str | None:
    expected = _terminals(error)
    if word.upper() in _BEHIND_RETURN and "_RETURN" in expected:
        return f"{word.upper()} stands behind RETURN"
    if word in (":", "]") and "LPAR" in expected:
        return "a pattern in WHERE stands in braces: EXISTS { (a)-[:DOOR]-(b) }"
    if word == "*" and "DISTINCT" in expected:
        return "RETURN * is not there; name the columns"
    if word in ("'", '"'):
        return "a text begins here and does not end"
    return None


def _word_at(error: UnexpectedInput, text: str) -> str:
    """Return the token at the fault, or an empty text at the end."""
    if isinstance(error, UnexpectedToken):
        return "" if error.token.type == "$END" else str(error.token)
    position = error.pos_in_stream or 0
    if text.startswith("=~", max(position - 1, 0)):
        return "=~"
    rest = text[position:]
    letters = len(rest) - len(rest.lstrip("".join({c for c in rest if c.isalnum() or c == "_"}) or "\0"))
    return rest[: max(letters, 1)]


def _terminals(error: UnexpectedInput) -> set[str]:
    if isinstance(error, UnexpectedToken):
        return set(error.accepts or error.expected)
    if isinstance(error, UnexpectedCharacters):
        return set(error.allowed or ())
    return set()


def _expected(error: UnexpectedInput) -> list[str]:
    names = sorted(_terminals(error) - _UNTOLD)
    return [_READABLE.get(name, name.lstrip("_")) for name in names]


def _listed(names: list[str]) -> str:
    shown = sorted(names, key=lambda name: (not name.isalpha() or name.startswith("a "), name))[:_MOST_TOLD]
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} or {shown[-1]}" if shown else "something else"


def _place_of(text: str, position: int) -> dict[str, int]:
    """Line and column of a position in the text, both counted from 1."""
    before = text[:position].split("\n")
    return {"line": len(before), "column": len(before[-1]) + 1}
