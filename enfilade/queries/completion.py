"""What may stand next in a question that is being written: keywords, labels, edge types, properties, names.

The parser itself says what it would take; the text before tells what a name there would be the name of.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from lark import Token, UnexpectedInput

from enfilade.schema.definition import NODE_PROPERTIES, NODES, Property

from .parse import parser
from .spelling import FUNCTIONS, quoted, unquoted
from .syntax import SCORES
from .vocabulary import EDGE_TYPES, edge_meaning, shared_properties


@dataclass(frozen=True, slots=True)
class Completion:
    """A word that may stand next.

    Attributes
    ----------
    text
        The word.
    typed
        How many letters of it stand there already, to be replaced.
    kind
        ``keyword``, ``label``, ``edge``, ``property``, ``name``, ``function``, ``parameter`` or ``value``.
    """

    text: str
    typed: int
    kind: str


_PHRASES: Final = {
    "_OPTIONAL": ("OPTIONAL MATCH",),
    "_ORDER": ("ORDER BY",),
    "_PER": ("PER BUILDING",),
    "_STARTS": ("STARTS WITH",),
    "_ENDS": ("ENDS WITH",),
    "_IS": ("IS NULL", "IS NOT NULL"),
    "_TRUE": ("true",),
    "_FALSE": ("false",),
    "_NULL": ("null",),
    "ASCENDING": ("ASC",),
    "DESCENDING": ("DESC",),
}
"""What is offered for a terminal that is more than its name."""

_WORDS: Final = ("ALL", "DISTINCT", "ASCENDING", "DESCENDING")
"""Keywords among the terminals that the tree keeps; the others begin with an underscore."""

_TYPED: Final = re.compile(r"\$?(?:[^\W\d]\w*)?\Z")
_OPENING: Final = {"LPAR": "(", "LSQB": "[", "LBRACE": "{"}
_CLOSING: Final = ("RPAR", "RSQB", "RBRACE")


def completions(before: str, after: str = "", *, parameters: Iterable[str] = ()) -> list[Completion]:
    """Return the words that may stand between two texts, those in question first.

    Parameters
    ----------
    before, after
        The question before and behind the place; what is behind only tells what names mean.
    parameters
        Names of the parameters that have values.
    """
    start, word = _split(before)
    try:
        tokens, accepted = _state_after(start)
    except UnexpectedInput:
        return []
    offered = _Offers(tokens, accepted, _names_in(f"{before} {after}"), parameters).all()
    wanted = word.casefold()
    return [
        Completion(text, len(word), kind)
        for text, kind in dict.fromkeys(offered)
        if text.casefold().startswith(wanted) and text != word
    ]


def _split(before: str) -> tuple[str, str]:
    """Return a text and the word at its end, which may be a name whose backquote is open."""
    typed = _TYPED.search(before)
    assert typed is not None
    place = before.rindex("`") if before.count("`") % 2 else typed.start()
    return before[:place], before[place:]


def _state_after(text: str) -> tuple[list[Token], set[str]]:
    """Return the tokens of a text that begins a question, and the terminals that may follow."""
    state = parser().parse_interactive(text)
    tokens = list(state.exhaust_lexer())
    return tokens, set(state.accepts())  # type: ignore[no-untyped-call]


_NODE: Final = re.compile(r"\(\s*(`(?:``|[^`])+`|[^\W\d]\w*)\s*:\s*(\w+)")
_EDGE: Final = re.compile(r"\[\s*(`(?:``|[^`])+`|[^\W\d]\w*)?\s*:\s*(\w+(?:\s*\|\s*:?\w+)*)")
_MENTION: Final = re.compile(r"\(\s*(`(?:``|[^`])+`|[^\W\d]\w*)\s*\)")


def _names_in(text: str) -> dict[str, Mapping[str, Property]]:
    """Return the properties of what each name of a question stands for, as far as its label or types tell."""
    names: dict[str, Mapping[str, Property]] = {}
    for found in _EDGE.finditer(text):
        types = tuple(re.findall(r"\w+", found[2]))
        if found[1] and all(type in EDGE_TYPES for type in types):
            meaning = edge_meaning(types)
            names[unquoted(found[1])] = meaning.properties() if meaning.is_node else shared_properties(types)
    for found in _NODE.finditer(text):
        names[unquoted(found[1])] = NODE_PROPERTIES.get(found[2], _all_properties())
    for found in _MENTION.finditer(text):
        names.setdefault(unquoted(found[1]), _all_properties())
    return names


def _all_properties() -> dict[str, Property]:
    return {name: known for label in NODES for name, known in NODE_PROPERTIES[label].items()}


def _is_keyword(terminal: str) -> bool:
    return terminal in _WORDS or (terminal.startswith("_") and not terminal.startswith("__"))


class _Offers:
    """Words that may follow a list of tokens."""

    def __init__(
        self,
        tokens: list[Token],
        accepted: set[str],
        names: Mapping[str, Mapping[str, Property]],
        parameters: Iterable[str],
    ) -> None:
        self._tokens = tokens
        self._accepted = accepted
        self._names = names
        self._parameters = parameters

    def all(self) -> Iterator[tuple[str, str]]:
        """Yield each word and its kind."""
        last = self._tokens[-1].type if self._tokens else ""
        inside, opened = self._innermost()
        if "NAME" in self._accepted:
            yield from self._named(last, inside, opened)
        if last == "COLON" and inside == "{":
            yield from self._values(opened)
        if "PARAMETER" in self._accepted:
            yield from ((f"${quoted(name)}", "parameter") for name in self._parameters)
        for terminal in sorted(filter(_is_keyword, self._accepted)):
            yield from ((word, "keyword") for word in _PHRASES.get(terminal, (terminal.lstrip("_"),)))

    def _named(self, last: str, inside: str, opened: int) -> Iterator[tuple[str, str]]:
        """Yield what a name here could be."""
        if last in ("COLON", "VBAR"):
            yield from (
                (name, "edge" if inside == "[" else "label") for name in (EDGE_TYPES if inside == "[" else NODES)
            )
        elif last == "DOT":
            yield from ((name, "property") for name in self._names.get(self._name_at(-2), _all_properties()))
        elif inside == "{" and "LPAR" not in self._accepted:
            yield from ((f"{name}: ", "property") for name, known in self._of_map(opened).items() if known.kind.scalar)
        elif last == "_LIKE":
            yield "object('", "function"
        elif last != "_AS" and not (inside == "[" and self._tokens[-1].type == "LSQB"):
            yield from ((quoted(name), "name") for name in self._names)
            if "NUMBER" in self._accepted:
                yield from ((name, "name") for name in SCORES)
                yield from ((f"{name}(", "function") for name in FUNCTIONS if name != "object")
                yield from (("EXISTS { ", "function"), ("count { ", "function"))

    def _innermost(self) -> tuple[str, int]:
        """Return the bracket that the place is in, and the number of its token."""
        stack: list[int] = []
        for number, token in enumerate(self._tokens):
            if token.type in _OPENING:
                stack.append(number)
            elif token.type in _CLOSING and stack:
                stack.pop()
        return (_OPENING[self._tokens[stack[-1]].type], stack[-1]) if stack else ("", 0)

    def _name_at(self, place: int) -> str:
        return unquoted(self._tokens[place]) if len(self._tokens) >= -place else ""

    def _of_map(self, opened: int) -> Mapping[str, Property]:
        """Properties of the node or edge whose map a brace opens."""
        first = next(i for i in range(opened - 1, -1, -1) if self._tokens[i].type in ("LPAR", "LSQB"))
        words = [unquoted(token) for token in self._tokens[first:opened] if token.type == "NAME"]
        if self._tokens[first].type == "LSQB":
            types = [word for word in words if word in EDGE_TYPES]
            return shared_properties(types) if types else {}
        label = next((word for word in words if word in NODES), None)
        if label is not None:
            return NODE_PROPERTIES[label]
        return self._names.get(words[0], _all_properties()) if words else _all_properties()

    def _values(self, opened: int) -> Iterator[tuple[str, str]]:
        """Yield the texts that a property may have."""
        known = self._of_map(opened).get(self._name_at(-2))
        yield from ((f"'{value}'", "value") for value in (() if known is None else known.values))
