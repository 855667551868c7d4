"""Cypher for Neo4j: one MATCH with every node told apart from the others."""

from __future__ import annotations

from collections.abc import Sequence

from .compiler import Compiled, Compiler, Search
from .expansion import Expansion, Link, Route


def compile_cypher(search: Search) -> Compiled:
    """Write a search as Cypher (version 5)."""
    return CypherCompiler.compile(search)


class CypherCompiler(Compiler):
    """Writes Cypher.

    All parts stand in one MATCH: there, and only there, Neo4j itself keeps relationships apart.
    """

    dialect = "cypher"
    mark = "$"

    def _statement(self, search: Search) -> str:
        columns = self._columns(search)
        conditions = self._wheres(search)
        where = "\nWHERE " + "\n  AND ".join(conditions) if conditions else ""
        return f"CYPHER 5 MATCH {', '.join(self._parts_of(search.expansion, inner=False))}{where}\nRETURN {columns}"

    def _subquery(self, kind: str, expansion: Expansion, conditions: Sequence[str]) -> str:
        parts = self._parts_of(expansion, inner=True)
        where = f" WHERE {' AND '.join(conditions)}" if conditions else ""
        return f"{kind.upper()} {{ MATCH {', '.join(parts)}{where} }}"

    def _parts_of(self, expansion: Expansion, *, inner: bool) -> list[str]:
        """Comma parts: an edge each, then the nodes without edges; a node shows its label where it comes first."""
        labels = {p.name: "" if inner and p.given else f":{p.label}" for p in expansion.points}
        new = {p.name: None for p in expansion.points}
        parts = [self._link(link, labels, new) for link in expansion.links]
        return parts + [self._node(name, labels, new) for name in list(new)]

    def _link(self, link: Link, labels: dict[str, str], new: dict[str, None]) -> str:
        source, target = (self._node(name, labels, new) for name in (link.source, link.target))
        return f"{source}-[{self._alias(link.name)}:{link.type}]-{'' if link.either else '>'}{target}"

    def _node(self, name: str, labels: dict[str, str], new: dict[str, None]) -> str:
        label = labels[name] if name in new else ""
        new.pop(name, None)
        return f"({self._alias(name)}{label})"

    def _route(self, route: Route) -> str:
        if route.left == route.right:
            return self._nothing("exists")
        return f"({' OR '.join(self._route_of(route, n) for n in range(route.low, route.high + 1))})"

    def _route_of(self, route: Route, length: int) -> str:
        inside = [self._new("n") for _ in range(length - 1)]
        rooms = [self._alias(route.left), *inside, self._alias(route.right)]
        steps = [self._new("x") for _ in range(length)]
        path, conditions = f"({rooms[0]})", []
        for step, room in zip(steps, rooms[1:], strict=True):
            label = ":Room" if room in inside else ""
            between = f"-[{step}:NEIGHBOUR]-" if route.neighbours else f"-[:OPENS]->({step}:Opening)<-[:OPENS]-"
            path += f"{between}({room}{label})"
            conditions += self._step_conditions(step, route)
        conditions += [
            f"{a} <> {b}" for i, a in enumerate(rooms) for b in rooms[i + 1 :] if {a, b} != {rooms[0], rooms[-1]}
        ]
        where = f" WHERE {' AND '.join(conditions)}" if conditions else ""
        return f"EXISTS {{ MATCH {path}{where} }}"

    def _step_conditions(self, step: str, route: Route) -> list[str]:
        found = [self._constraint(step, entry) for entry in route.constraints]
        if route.kinds is not None:
            found.append(self._in(f"{step}.kind", [self._parameter(kind) for kind in route.kinds]))
        return found

    def _same_parts(self, a: str, b: str) -> str:
        return f"any(x IN {self._segments(a)} WHERE x IN {self._segments(b)})"

    def _segments(self, alias: str) -> str:
        own = f"[y IN {self._numbers(alias)} | {alias}.building + '/' + y]"
        return f"coalesce({alias}.segments, {own})"

    def _numbers(self, alias: str) -> str:
        """Return the parts of an object's key as a list: ``["o31", "o32"]``."""
        return f"split(split({alias}.id, '/')[1], '+')"

    def _parts(self, alias: str) -> str:
        return f"coalesce({alias}.parts, size({alias}.segments), size({self._numbers(alias)}))"

    def _property(self, alias: str, name: str) -> str:
        return f"{alias}.{name}"

    def _key(self, alias: str) -> str:
        return f"elementId({alias})"

    def _same(self, left: str, operator: str, right: str) -> str:
        return f"{left} {operator} {right}"

    def _in(self, item: str, values: Sequence[str]) -> str:
        return f"({item} IN [{', '.join(values)}])"

    def _among(self, item: str, parameter: str) -> str:
        return f"{item} IN {parameter}"

    def _text_test(self, operator: str, left: str, right: str, value: str) -> str:
        return f"({left} {operator} {right})"

    def _xor(self, operands: Sequence[str]) -> str:
        return f"({' XOR '.join(operands)})"
