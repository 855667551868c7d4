"""What a question is answered with."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from .explanation import Explanation

if TYPE_CHECKING:
    import pandas as pd


UNMET: Final = "unmet"
"""Name of the column that RELAX adds."""


@dataclass(frozen=True, slots=True)
class Unmet:
    """A condition that a near miss does not meet.

    Attributes
    ----------
    condition
        As the question has it.
    excess
        How far off it is: 0 is only just not, 1 is not at all.
    """

    condition: str
    excess: float


@dataclass(frozen=True, slots=True)
class Result:
    """Ranked rows and how they were found.

    Attributes
    ----------
    columns
        Names, as in RETURN; after RELAX ``unmet`` behind them.
    rows
        One dict a row; a node is its id.
    explanation
        Statements, counts and times.
    unmet
        What each row does not meet, after RELAX; nothing for a full match.
    left_out
        Rows that the limit on their number left out.
    """

    columns: list[str]
    rows: list[dict[str, Any]]
    explanation: Explanation
    unmet: list[tuple[Unmet, ...]] = field(default_factory=list)
    left_out: int = 0

    @property
    def explain(self) -> str:
        """How the answer was found, as text."""
        return str(self.explanation)

    def to_pandas(self) -> pd.DataFrame:
        """Return the rows as a data frame."""
        import pandas as pd  # takes longer to load than most questions to answer

        return pd.DataFrame(self.rows, columns=self.columns)

    def __len__(self) -> int:
        return len(self.rows)
