"""What a question is answered with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .explanation import Explanation

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True)
class Result:
    """Ranked rows and how they were found.

    Attributes
    ----------
    columns
        Names, as in RETURN.
    rows
        One dict a row; a node is its id.
    explanation
        Statements, counts and times.
    """

    columns: list[str]
    rows: list[dict[str, Any]]
    explanation: Explanation

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
