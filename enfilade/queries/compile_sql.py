"""SQL for the embedded store: a table a node label, a table an edge type, joined by primary keys."""

from __future__ import annotations

from collections.abc import Sequence

from enfilade.errors import UnsupportedError
from enfilade.schema.sqlite import quoted, table

from .compiler import Compiled, Compiler, Search
from .expansion import Expansion, Link, Route

MOST_TABLES = 64
"""What SQLite can join in one statement."""


def compile_sql(search: Search) -> Compiled:
    """Write a search as SQL.

    Raises
    ------
    UnsupportedError
        If the pattern has more nodes and edges than SQLite can join.
    """
    return SqlCompiler.compile(search)


class SqlCompiler(Compiler):
    """Writes SQL for SQLite.

    The text is put together from names of the schema, aliases made here and marks of parameters, never from values:
    what a linter takes for injection (S608) is none.
    """

    dialect = "sql"
    mark = ":"

    def _statement(self, search: Search) -> str:
        tables = self._tables(search.expansion, inner=False)
        if len(tables) > MOST_TABLES:
            raise UnsupportedError(
                f"SQLite joins at most {MOST_TABLES} tables and this pattern needs {len(tables)};"
                " ask for a smaller one, or use a Neo4j store."
            )
        columns = self._columns(search)
        conditions = self._joins(search.expansion) + self._wheres(search)
        where = "\nWHERE " + "\n  AND ".join(conditions) if conditions else ""
        places = ", ".join(str(number) for number, _ in enumerate(search.columns, start=1))
        grouped = f"\nGROUP BY {places}" if search.tally and places else ""
        return f"SELECT {columns}\nFROM {', '.join(tables)}{where}{grouped}"

    def _subquery(self, kind: str, expansion: Expansion, conditions: Sequence[str]) -> str:
        tables = self._tables(expansion, inner=True)
        source = f" FROM {', '.join(tables)}" if tables else ""
        every = self._joins(expansion) + list(conditions)
        where = f" WHERE {' AND '.join(every)}" if every else ""
        if kind == "exists":
            return f"EXISTS (SELECT 1{source}{where})"
        return f"(SELECT count(*){source}{where})"

    def _tables(self, expansion: Expansion, *, inner: bool) -> list[str]:
        points = [(point.label, point.name) for point in expansion.points if not (inner and point.given)]
        links = [(link.type, link.name) for link in expansion.links]
        return [f"{table(kind)} AS {quoted(self._alias(name))}" for kind, name in points + links]

    def _joins(self, expansion: Expansion) -> list[str]:
        return [self._join(link) for link in expansion.links]

    def _join(self, link: Link) -> str:
        edge, source, target = (quoted(self._alias(name)) for name in (link.name, link.source, link.target))
        ahead = f"{edge}.source = {source}.pk AND {edge}.target = {target}.pk"
        if not link.either:
            return ahead
        return f"(({ahead}) OR ({edge}.source = {target}.pk AND {edge}.target = {source}.pk))"

    def _route(self, route: Route) -> str:
        if route.left == route.right:
            return self._nothing("exists")
        return f"({' OR '.join(self._route_of(route, n) for n in range(route.low, route.high + 1))})"

    def _route_of(self, route: Route, length: int) -> str:
        rooms = [f"{quoted(self._alias(route.left))}.pk"]
        tables: list[str] = []
        conditions: list[str] = []
        for _ in range(length):
            step = self._neighbour_step if route.neighbours else self._opening_step
            rooms.append(step(route, rooms[-1], tables, conditions))
        end = f"{quoted(self._alias(route.right))}.pk"
        conditions.append(f"{rooms.pop()} = {end}")
        rooms.append(end)
        conditions += [f"{a} <> {b}" for i, a in enumerate(rooms) for b in rooms[i + 1 :] if (i, b) != (0, end)]
        return f"EXISTS (SELECT 1 FROM {', '.join(tables)} WHERE {' AND '.join(conditions)})"  # noqa: S608

    def _opening_step(self, route: Route, room: str, tables: list[str], conditions: list[str]) -> str:
        enter, opening, leave = self._new("e"), self._new("x"), self._new("e")
        tables += [f'"opens" AS {enter}', f'"opening" AS {opening}', f'"opens" AS {leave}']
        conditions += [
            f"{enter}.source = {room} AND {enter}.target = {opening}.pk",
            f"{leave}.target = {opening}.pk",
            *(self._constraint(opening, entry) for entry in route.constraints),
        ]
        if route.kinds is not None:
            kinds = [self._parameter(kind) for kind in route.kinds]
            conditions.append(self._in(self._property(opening, "kind"), kinds))
        return f"{leave}.source"

    def _neighbour_step(self, route: Route, room: str, tables: list[str], conditions: list[str]) -> str:
        edge, following = self._new("e"), self._new("n")
        tables += [f'"neighbour" AS {edge}', f'"room" AS {following}']
        conditions += [
            f"(({edge}.source = {room} AND {edge}.target = {following}.pk)"
            f" OR ({edge}.target = {room} AND {edge}.source = {following}.pk))",
            *(self._constraint(edge, entry) for entry in route.constraints),
        ]
        return f"{following}.pk"

    def _same_parts(self, a: str, b: str) -> str:
        both = f"{self._segments(a, 'x')} JOIN {self._segments(b, 'y')} ON x.value = y.value"
        return f"EXISTS (SELECT 1 FROM {both})"  # noqa: S608

    def _segments(self, alias: str, name: str) -> str:
        building = self._property(alias, "building")
        own = f"(SELECT json_group_array({building} || '/' || value) FROM json_each({self._numbers(alias)}))"  # noqa: S608
        return f"json_each(coalesce({self._property(alias, 'segments')}, {own})) AS {name}"

    def _numbers(self, alias: str) -> str:
        """Return the parts of an object's key as a JSON array: ``["o31","o32"]``."""
        id, building = self._property(alias, "id"), self._property(alias, "building")
        return f"""'["' || replace(substr({id}, length({building}) + 2), '+', '","') || '"]'"""

    def _parts(self, alias: str) -> str:
        parts, segments = self._property(alias, "parts"), self._property(alias, "segments")
        return f"coalesce({parts}, json_array_length({segments}), json_array_length({self._numbers(alias)}))"

    def _property(self, alias: str, name: str) -> str:
        return f"{quoted(alias)}.{quoted(name)}"

    def _key(self, alias: str) -> str:
        return f"{quoted(alias)}.pk"

    def _same(self, left: str, operator: str, right: str) -> str:
        return f"{quoted(left)}.pk {operator} {quoted(right)}.pk"

    def _in(self, item: str, values: Sequence[str]) -> str:
        return f"({item} IN ({', '.join(values)}))"

    def _among(self, item: str, parameter: str) -> str:
        return f"{item} IN (SELECT value FROM json_each({parameter}))"  # noqa: S608

    def _text_test(self, operator: str, left: str, right: str, value: str) -> str:
        if not value:  # every text has the empty one in it, but what is missing stays unknown
            return f"({left} = {left})"
        if operator == "ENDS WITH":
            return f"(substr({left}, -length({right})) = {right})"
        return f"(instr({left}, {right}) {'= 1' if operator == 'STARTS WITH' else '> 0'})"

    def _xor(self, operands: Sequence[str]) -> str:
        text = operands[0]
        for operand in operands[1:]:
            text = f"({text} <> {operand})"
        return text
