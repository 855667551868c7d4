"""The query graph as plain values that JSON can hold, and back."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Final

from enfilade.errors import QuestionError

from . import query_graph, syntax
from .printing import printed
from .query_graph import QueryGraph

_NOT_WRITTEN: Final = ("place", "text")
_CLASSES: Final[dict[str, type]] = {
    cls.__name__: cls
    for cls in (
        *(getattr(query_graph, name) for name in ("Equal", "Between", "Likeness", "NodePattern", "EdgePattern")),
        *(getattr(query_graph, name) for name in ("Pattern", "Column", "SortKey", "QueryGraph")),
        *syntax.Expression.__subclasses__(),
    )
}


def encode(query: QueryGraph) -> dict[str, Any]:
    """Return a question as plain values: a mapping with ``is`` and its fields for each part."""
    document = _plain(query)
    assert isinstance(document, dict)
    return document


def decode(document: Any) -> QueryGraph:
    """Return the question that was encoded.

    Raises
    ------
    QuestionError
        If the document is no question.
    """
    query = _structured(document)
    if not isinstance(query, QueryGraph):
        raise QuestionError('the outermost part of a question in JSON must be a "QueryGraph".')
    try:
        printed(query)  # goes through every part
    except (AttributeError, KeyError, TypeError) as error:
        raise QuestionError(f"a part of the question in JSON stands where another belongs: {error}.") from None
    return query


def _plain(value: Any) -> Any:
    if type(value).__name__ in _CLASSES:
        spots = (spot.name for spot in fields(value) if spot.name not in _NOT_WRITTEN)
        return {"is": type(value).__name__, **{name: _plain(getattr(value, name)) for name in spots}}
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def _structured(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(map(_structured, value))
    if not isinstance(value, dict):
        return value
    kind = _CLASSES.get(value.get("is", ""))
    if kind is None:
        raise QuestionError(f'a part of the question in JSON says "is": {value.get("is")!r}, which is no part.')
    given = {name: _structured(part) for name, part in value.items() if name != "is"}
    try:
        return kind(**given)
    except TypeError as error:
        raise QuestionError(f"a {value['is']} of the question in JSON is not whole: {error}.") from None
