"""How an answer was found: what was asked of the store, what was done after it, and how long each took."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .compiler import Compiled, GivenIds, LikeIds
from .printing import expression_text
from .syntax import Expression


@dataclass(slots=True)
class Step:
    """One statement sent to the store.

    Attributes
    ----------
    title
        Which part of the question it is.
    text, parameters
        The statement.
    after
        Conditions that the store does not test; they are tested on its rows.
    rows, kept
        Rows that came, and matches left after the conditions; None where the question was not run.
    seconds
        Time for both.
    """

    title: str
    text: str
    parameters: dict[str, Any]
    after: list[str]
    rows: int | None = None
    kept: int | None = None
    seconds: float | None = None

    def __str__(self) -> str:
        lines = [f"-- {self.title}", self.text]
        lines += [f"   {name} = {value!r}" for name, value in self.parameters.items()]
        lines += [f"   tested on the rows: {condition}" for condition in self.after]
        if self.rows is not None:
            lines.append(f"   {self.rows} rows, {self.kept} kept, {1000 * (self.seconds or 0):.1f} ms")
        return "\n".join(lines)


@dataclass(slots=True)
class Explanation:
    """The steps of an answer and its counts.

    `counts` holds numbers by what they count, `seconds` the time of what is done beside the statements.
    """

    store: str
    steps: list[Step] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values for JSON."""
        steps = [{name: getattr(step, name) for name in Step.__slots__} for step in self.steps]
        return {"store": self.store, "steps": steps, "counts": self.counts, "seconds": self.seconds}

    def __str__(self) -> str:
        lines = [f"-- store: {self.store}", *map(str, self.steps)]
        lines += [f"-- {what}: {count}" for what, count in self.counts.items()]
        lines += [f"-- {what}: {1000 * seconds:.1f} ms" for what, seconds in self.seconds.items()]
        return "\n".join(lines)


def step_of(title: str, compiled: Compiled, after: Sequence[Expression]) -> Step:
    """Return the step that a statement is, before it is run."""
    return Step(title, compiled.text, shown_parameters(compiled.parameters), [expression_text(e) for e in after])


def shown_parameters(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters with a few words in place of long lists of ids."""
    return {name: _shown(value) for name, value in parameters.items()}


def _shown(value: Any) -> Any:
    if isinstance(value, LikeIds):
        limit = "" if value.likeness.within is None else f" WITHIN {expression_text(value.likeness.within)}"
        return f"ids of objects LIKE {expression_text(value.likeness.reference)}{limit}"
    return f"ids that {value.name} has so far" if isinstance(value, GivenIds) else value
