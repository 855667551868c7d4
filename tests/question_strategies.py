"""Query graphs as somebody might build them by hand: every part of the language, hostile names and texts included."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from enfilade.queries.query_graph import (
    Between,
    Column,
    EdgePattern,
    Equal,
    Likeness,
    NodePattern,
    Pattern,
    QueryGraph,
    SortKey,
)
from enfilade.queries.syntax import (
    AGGREGATES,
    Arithmetic,
    Call,
    Comparison,
    Expression,
    IsNull,
    ListOf,
    Literal,
    Logic,
    Membership,
    Negative,
    Not,
    Parameter,
    PropertyOf,
    Subquery,
    TextTest,
    Variable,
)

texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
names = st.sampled_from(["a", "b", "room 1", "match", "é", "`", "and", "x\ny"]) | texts.filter(
    lambda name: name and not name.startswith("#") and name not in ("score", "mean_score")
)
numbers = st.integers(-(10**12), 10**12) | st.floats(allow_nan=False, allow_infinity=False)
parameters = st.builds(Parameter, names)
ends = st.builds(Literal, numbers) | parameters
values = ends | st.builds(Literal, texts | st.booleans() | st.none())
labels = st.sampled_from(["Room", "Object", "Building", "No such", "like"])
types = st.lists(st.sampled_from(["DOOR", "STAIRS", "CONTAINS", "NEAR", "IN", "no-edge"]), min_size=1, max_size=3)
constraints = st.builds(Equal, names, values) | st.one_of(
    st.builds(Between, names, ends, ends), st.builds(Between, names, ends), st.builds(Between, names, st.none(), ends)
)
maps = st.lists(constraints, max_size=2).map(tuple)
examples = st.builds(Literal, texts) | parameters
examples |= examples.map(lambda inside: Call("object", (inside,)))
likenesses = st.builds(Likeness, examples, st.none() | ends, st.none() | st.tuples(ends, ends))


def expressions(depth: int = 2) -> st.SearchStrategy[Expression]:
    """Expressions, whether they make sense or not."""
    atoms = values | st.builds(Variable, names) | st.builds(PropertyOf, names, names) | st.just(Call("count", ()))
    return st.recursive(
        atoms | st.builds(Subquery, st.sampled_from(["exists", "count"]), patterns(depth - 1)) if depth else atoms,
        _larger,
        max_leaves=5,
    )


def _larger(inside: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    several = st.lists(inside, min_size=2, max_size=3).map(tuple)
    not_a_number = inside.filter(lambda e: not isinstance(e, Literal))  # -(5) is the number -5
    calls = st.builds(Call, st.sampled_from(["like", "object", "no function"]), several)
    return st.one_of(
        calls,
        st.builds(Call, st.sampled_from(AGGREGATES), inside.map(lambda e: (e,)), st.booleans()),
        st.builds(Logic, st.sampled_from(["AND", "OR", "XOR"]), several),
        st.builds(Comparison, st.sampled_from(["=", "<>", "<", "<=", ">", ">="]), inside, inside),
        st.builds(Arithmetic, st.sampled_from("+-*/%^"), inside, inside),
        st.builds(TextTest, st.sampled_from(["STARTS WITH", "ENDS WITH", "CONTAINS"]), inside, inside),
        st.builds(Membership, inside, inside),
        st.builds(IsNull, inside, st.booleans()),
        st.builds(ListOf, several),
        st.builds(Not, inside),
        st.builds(Negative, not_a_number),
    )


@st.composite
def patterns(draw: st.DrawFn, depth: int = 1) -> Pattern:
    """Patterns as chains, which nodes with a name may share, with parallel edges and loops."""
    nodes: dict[str, NodePattern] = {}
    edges: list[EdgePattern] = []

    def mention() -> str:
        name = draw(st.none() | names) or f"#{sum(known.startswith('#') for known in nodes) + 1}"
        if name not in nodes:
            nodes[name] = NodePattern(name, draw(st.none() | labels), draw(maps), draw(st.none() | likenesses))
        return name

    for _ in range(draw(st.integers(1, 3))):
        end = mention()
        for following in (mention() for _ in range(draw(st.integers(0, 2)))):
            edges.append(draw(_edges(end, following)))
            end = following
    return Pattern(tuple(nodes.values()), tuple(edges), draw(st.none() | expressions(depth)) if depth else None)


def _edges(left: str, right: str) -> st.SearchStrategy[EdgePattern]:
    hops = st.none() | st.tuples(st.integers(1, 3), st.integers(3, 10))
    kinds = types.map(lambda given: tuple(dict.fromkeys(given)))
    named = st.just("#") | names
    return st.builds(EdgePattern, st.just(left), st.just(right), kinds, st.sampled_from("-<>"), maps, hops, named)


def query_graphs() -> st.SearchStrategy[QueryGraph]:
    """Whole questions."""
    columns = st.lists(st.builds(Column, names, expressions(1)), min_size=1, max_size=3).map(tuple)
    numbers_of_rows: dict[str, Any] = {name: st.none() | ends for name in ("skip", "limit", "per_building", "relax")}
    return st.builds(
        QueryGraph,
        patterns(),
        columns,
        st.lists(patterns(), max_size=2).map(tuple),
        st.booleans(),
        st.booleans(),
        st.lists(st.builds(SortKey, expressions(1), st.booleans()), max_size=2).map(tuple),
        **numbers_of_rows,
    )
