"""What went wrong, where, and why as far as the comparison can tell: one record a fault."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, Final

SUBJECTS: Final = ("room", "storey", "opening", "connection", "neighbour", "object")


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that truth and prediction do not agree on.

    Attributes
    ----------
    subject
        One of `SUBJECTS`.
    fault
        ``missed``, ``invented``, ``split``, ``merged``, ``misplaced``, ``loose``.
    side
        Which graph `id` is a key of: ``truth`` or ``prediction``.
    id, name
        Key of the node, and what people call it.
    cause
        A word for programs, such as ``wrong_rooms``.
    why
        The cause for people, in a few words.
    kind
        Of an opening: ``door``, ``outside door``, ``window``, ``stairs``.
    others
        Keys of the nodes of the other graph that have to do with it.
    """

    subject: str
    fault: str
    side: str
    id: str
    name: str
    cause: str
    why: str
    kind: str = ""
    others: tuple[str, ...] = ()

    @property
    def what(self) -> str:
        """The sort of fault, as the table calls it."""
        subject = {"door": "opening", "": self.subject}.get(self.kind, self.kind)
        plural = subject if subject == "stairs" else f"{subject}s"
        return f"{plural} {self.fault}"

    def to_dict(self) -> dict[str, Any]:
        """Return the record as plain values."""
        return asdict(self) | {"others": list(self.others)}


def count_causes(faults: Iterable[Fault]) -> dict[str, int]:
    """Return how often each sort of fault has each cause, the commonest first."""
    counted = Counter(f"{fault.what}: {fault.cause}" for fault in faults)
    return dict(sorted(counted.items(), key=lambda pair: (-pair[1], pair[0])))
