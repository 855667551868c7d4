"""A store to ask, for use from Python."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from enfilade.descriptors import Shape
from enfilade.stores import Store

from .answering import MOST_ROWS, answer
from .query_graph import QueryGraph
from .result import Result


class Connection:
    """An open store that answers questions; closed at the end of a ``with`` block.

    Attributes
    ----------
    store
        The store itself.
    """

    def __init__(self, store: Store) -> None:
        self.store = store

    def query(
        self,
        question: str | QueryGraph,
        *,
        likenesses: Mapping[str, Any] | None = None,
        timeout_s: float | None = 60.0,
        most_rows: int | None = MOST_ROWS,
        **parameters: Any,
    ) -> Result:
        """Answer a question.

        Parameters
        ----------
        question
            Text, or a query graph.
        likenesses
            Examples that LIKE names as parameters; a path or a shape among `parameters` is one as well.
        timeout_s
            Seconds after which to give up; None for never.
        most_rows
            Rows that are returned at most; None for all.
        parameters
            Values of ``$names``.
        """
        examples = {name: value for name, value in parameters.items() if isinstance(value, Path | Shape)}
        values = {name: value for name, value in parameters.items() if name not in examples}
        return answer(
            self.store,
            question,
            parameters=values,
            likenesses={**examples, **(likenesses or {})},
            timeout_s=timeout_s,
            most_rows=most_rows,
        )

    def close(self) -> None:
        """Close the store."""
        self.store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
