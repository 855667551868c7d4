"""How an answer was found: what was asked of the store, what was done after it, and how long each took."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from typing import Any

from .compiler import BestIds, Compiled, GivenIds, LikeIds
from .examples import Examples
from .expansion import Point
from .printing import expression_text
from .query_graph import Likeness
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


@dataclass(frozen=True, slots=True)
class LikenessSearch:
    """What it took to find what is like one example.

    Attributes
    ----------
    example
        As the question names it.
    candidates
        Objects that can be compared with it.
    bounds
        Lower bounds computed; an object that is looked at more closely has up to three.
    distances
        Objects that were measured, a mesh with all its views counted once.
    pruned
        Objects that were not.
    """

    example: str
    candidates: int
    bounds: int
    distances: int
    pruned: int

    def __str__(self) -> str:
        return (
            f"-- like {self.example}: {self.candidates} candidates, {self.bounds} bounds computed, "
            f"{self.distances} distances computed, {self.pruned} pruned"
        )


@dataclass(slots=True)
class Explanation:
    """The steps of an answer and its counts.

    `likeness` has an entry for each example, `counts` numbers by what they count, `seconds` the time of what is done
    beside the statements.
    """

    store: str
    steps: list[Step] = field(default_factory=list)
    likeness: list[LikenessSearch] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def timed(self, what: str) -> Iterator[None]:
        """Add the time that the block takes."""
        start = time.perf_counter()
        yield
        self.seconds[what] = self.seconds.get(what, 0.0) + time.perf_counter() - start

    def tell_likeness(self, examples: Examples) -> None:
        """Note what it took to find what is like the examples."""
        for (reference, at), effort in examples.efforts.items():
            height = "" if at is None else " AT " + "..".join(dict.fromkeys(map(expression_text, at)))
            text = f"{expression_text(reference)}{height}"
            entry = LikenessSearch(text, effort.candidates, effort.bounds, effort.distances, effort.pruned)
            self.likeness.append(entry)
        if self.likeness:
            self.counts["buildings whose descriptors were read"] = examples.described.read_anew
            self.seconds["reading descriptors"] = examples.described.seconds

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values for JSON."""
        return {
            "store": self.store,
            "steps": [asdict(step) for step in self.steps],
            "likeness": [asdict(search) for search in self.likeness],
            "counts": self.counts,
            "seconds": self.seconds,
        }

    def __str__(self) -> str:
        lines = [f"-- store: {self.store}", *map(str, self.steps), *map(str, self.likeness)]
        lines += [f"-- {what}: {count}" for what, count in self.counts.items()]
        lines += [f"-- {what}: {1000 * seconds:.1f} ms" for what, seconds in self.seconds.items()]
        return "\n".join(lines)


def step_of(title: str, compiled: Compiled, after: Iterable[Expression], likened: Iterable[Point]) -> Step:
    """Return the step that a statement is, before it is run; what is tested on its rows are conditions and likeness."""
    tested = [f"{p.name} LIKE {likeness_text(p.likeness)}" for p in likened if p.likeness is not None]
    tested += [expression_text(expression) for expression in after]
    return Step(title, compiled.text, shown_parameters(compiled.parameters), tested)


def likeness_text(likeness: Likeness) -> str:
    """Return what stands behind LIKE."""
    limit = "" if likeness.within is None else f" WITHIN {expression_text(likeness.within)}"
    return f"{expression_text(likeness.reference)}{limit}"


def shown_parameters(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters with a few words in place of long lists of ids."""
    return {name: _shown(value) for name, value in parameters.items()}


def _shown(value: Any) -> Any:
    if isinstance(value, LikeIds):
        return f"ids of objects LIKE {likeness_text(value.likeness)}"
    if isinstance(value, BestIds):
        return f"ids of the objects that {value.name} is asked for"
    return f"ids that {value.name} has so far" if isinstance(value, GivenIds) else value
