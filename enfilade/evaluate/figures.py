"""Figures that can be added up: counts and lists of errors are kept, shares and medians are made of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from statistics import median
from typing import Any, ClassVar, Self

import numpy as np


@dataclass(frozen=True, slots=True)
class Figures:
    """Base of all figures.

    Fields are what can be pooled: whole numbers, numbers, lists of numbers, and figures again. A list of names is
    one building's own and is not pooled. `DERIVED` names the properties that follow from them.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return fields and derived figures as plain values."""
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        plain = {name: value.to_dict() if isinstance(value, Figures) else _listed(value) for name, value in own.items()}
        return plain | {name: getattr(self, name) for name in self.DERIVED}

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> Self:
        """Return the figures that `to_dict` gave; what a record lacks counts as nothing."""
        empty = cls()
        given: dict[str, Any] = {}
        for field in fields(cls):
            default = getattr(empty, field.name)
            value = record.get(field.name, default)
            if isinstance(default, Figures):
                value = value if isinstance(value, Figures) else type(default).from_dict(value)
            given[field.name] = tuple(value) if isinstance(default, tuple) else value
        return cls(**given)

    @classmethod
    def pooled(cls, parts: Sequence[Self]) -> Self:
        """Return the figures of several buildings as those of one."""
        return cls(**{field.name: _pooled([getattr(part, field.name) for part in parts]) for field in fields(cls)})


def _pooled(values: list[Any]) -> Any:
    if not values:
        return 0
    if isinstance(values[0], Figures):
        return type(values[0]).pooled(values)
    if isinstance(values[0], tuple):
        return tuple(value for each in values for value in each if not isinstance(value, str))
    return sum(values)


def _listed(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def share(part: float, whole: float) -> float | None:
    """Part of a whole, None of nothing."""
    return part / whole if whole else None


def f1(right: int, predicted: int, true: int) -> float:
    """Harmonic mean of precision and recall; 1 where there is nothing to find and nothing was found."""
    return 2 * right / (predicted + true) if predicted + true else 1.0


def middle(errors: Iterable[float]) -> float | None:
    """Median, None of nothing."""
    given = list(errors)
    return float(median(given)) if given else None


def ninth_decile(errors: Sequence[float]) -> float | None:
    """90th percentile, None of nothing."""
    return float(np.percentile(errors, 90)) if errors else None
