"""What can go wrong, in one tree.

::

    EnfiladeError            every error that Enfilade raises on purpose
    ├── InputError           a scan, mesh, cloud or CSV file that cannot be used
    ├── GraphError           a graph (or graph.json) that the schema refuses
    ├── QuestionError        a question that cannot be understood; knows line and column
    ├── StoreError           a store that cannot be opened, reached or written
    │   └── VersionError     a store of another schema version
    ├── NotFoundError        no such building, node or file name in the store
    ├── UnsupportedError     what this store or engine cannot do, with what to use instead
    └── ServerError          the local Neo4j server cannot be installed, started or stopped

Each message is one sentence: what is wrong, where, and what to do.
"""

from __future__ import annotations


class EnfiladeError(Exception):
    """Base of all errors that Enfilade raises on purpose."""


class InputError(EnfiladeError):
    """A scan, mesh, cloud or table file cannot be used."""


class GraphError(EnfiladeError):
    """A graph breaks the schema."""


class QuestionError(EnfiladeError):
    """A question cannot be understood.

    Parameters
    ----------
    message
        One sentence: what is wrong and what to use instead.
    text
        The whole question, if known.
    line, column
        Place of the fault in `text`, both counted from 1, if known.
    """

    def __init__(
        self,
        message: str,
        *,
        text: str | None = None,
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        self.message = message
        self.text = text
        self.line = line
        self.column = column
        super().__init__(self._render())

    def _render(self) -> str:
        if self.text is None or self.line is None or self.column is None:
            return self.message
        lines = self.text.splitlines() or [""]
        shown = lines[min(self.line, len(lines)) - 1].expandtabs(1)
        caret = " " * (self.column - 1) + "^"
        return f"line {self.line}, column {self.column}: {self.message}\n  {shown}\n  {caret}"


class StoreError(EnfiladeError):
    """A store cannot be opened, reached, read or written."""


class VersionError(StoreError):
    """A store or a file carries another schema version."""


class NotFoundError(EnfiladeError):
    """No such building, node or name in the store."""


class UnsupportedError(EnfiladeError):
    """What is asked cannot be done here; the message says what to use instead."""


class ServerError(EnfiladeError):
    """The local Neo4j server cannot be installed, started or stopped."""
