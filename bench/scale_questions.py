"""The questions of the bench: in our language and, where it can say the same, in Cypher and SQL as an expert writes it.

``$room``, ``$building``, ``$thing`` and ``$basin`` are of another building each time a question is asked. Every
version of a question gives as many rows. Expert's Cypher is for Neo4j 5; SQL is for DuckDB, whose tables have the names
and columns of the embedded store's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Asked:
    """One question.

    Attributes
    ----------
    name, kind
        What it is called, and which of the kinds it is of.
    text
        In our language.
    cypher, sql
        The same by hand, or empty.
    vf2
        Whether a pattern alone is asked for, which networkx can look for, too.
    """

    name: str
    kind: str
    text: str
    cypher: str = ""
    sql: str = ""
    vf2: bool = False


QUESTIONS: Final = (
    Asked(
        "doors of a room",
        "anchored",
        "MATCH (a:Room {id: $room})-[d:DOOR]-(b:Room) RETURN b, d.width",
        "MATCH (:Room {id: $room})-[:OPENS]->(d:Opening {kind: 'door'})<-[:OPENS]-(b:Room) RETURN b.id, d.width",
        "SELECT b.id, d.width FROM room a JOIN opens e ON e.source = a.pk JOIN opening d ON d.pk = e.target "
        "JOIN opens f ON f.target = d.pk AND f.source <> a.pk JOIN room b ON b.pk = f.source "
        "WHERE a.id = $room AND d.kind = 'door'",
    ),
    Asked(
        "rooms two doors away",
        "anchored",
        "MATCH (a:Room {id: $room})-[:DOOR]-(b:Room)-[:DOOR]-(c:Room) RETURN b, c",
        "MATCH (a:Room {id: $room})-[:OPENS]->(d:Opening {kind: 'door'})<-[:OPENS]-(b:Room)"
        "-[:OPENS]->(e:Opening {kind: 'door'})<-[:OPENS]-(c:Room) WHERE c <> a AND d <> e RETURN b.id, c.id",
        "SELECT b.id, c.id FROM room a JOIN opens e ON e.source = a.pk JOIN opening d ON d.pk = e.target "
        "JOIN opens f ON f.target = d.pk AND f.source <> a.pk JOIN room b ON b.pk = f.source "
        "JOIN opens g ON g.source = b.pk AND g.target <> d.pk JOIN opening h ON h.pk = g.target "
        "JOIN opens i ON i.target = h.pk AND i.source <> b.pk JOIN room c ON c.pk = i.source "
        "WHERE a.id = $room AND d.kind = 'door' AND h.kind = 'door' AND c.pk <> a.pk",
    ),
    Asked(
        "everything in a building",
        "anchored",
        "MATCH (b:Building {id: $building})-[:HAS_STOREY]->(s)-[:HAS_ROOM]->(r)-[:CONTAINS]->(o) RETURN s, r, o",
        "MATCH (:Building {id: $building})-[:HAS_STOREY]->(s)-[:HAS_ROOM]->(r)-[:CONTAINS]->(o {parts: 1}) "
        "RETURN s.id, r.id, o.id",
    ),
    Asked(
        "large rooms of a building",
        "anchored",
        "MATCH (r:Room {building: $building}) WHERE r.area > 10 RETURN r, r.area ORDER BY r.area DESC",
        "MATCH (r:Room {building: $building}) WHERE r.area > 10 RETURN r.id, r.area ORDER BY r.area DESC",
        "SELECT id, area FROM room WHERE building = $building AND area > 10 ORDER BY area DESC",
    ),
    Asked(
        "kitchen of a building, near the stairs",
        "anchored",
        "MATCH (k:Room {building: $building, function: 'kitchen'})-[:DOOR|PASSAGE]-(h:Room)-[:STAIRS]-(u:Room) "
        "RETURN k, h, u",
        "MATCH (k:Room {building: $building, function: 'kitchen'})-[:OPENS]->(d:Opening)<-[:OPENS]-(h:Room)"
        "-[:OPENS]->(:Opening {kind: 'stairs'})<-[:OPENS]-(u:Room) WHERE d.kind IN ['door', 'passage'] AND u <> k "
        "RETURN k.id, h.id, u.id",
    ),
    Asked(
        "what stands beside an object",
        "anchored",
        "MATCH (o:Object {id: $thing})-[n:NEAR]-(p:Object) RETURN p, n.distance",
        "MATCH (o:Object {id: $thing})-[n:NEAR]-(p:Object {parts: 1}) RETURN p.id, n.distance",
    ),
    Asked(
        "kitchens three doors away",
        "anchored",
        "MATCH (a:Room {id: $room})-[:DOOR*1..3]-(b:Room {function: 'kitchen'}) RETURN b",
        "MATCH (a:Room {id: $room}) MATCH p = (a)(()-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-()){1,3}"
        "(b:Room {function: 'kitchen'}) WHERE b <> a RETURN DISTINCT b.id",
    ),
    Asked(
        "garage beside a kitchen",
        "selective",
        "MATCH (g:Room {function: 'garage', area: 40..})-[:DOOR]-(k:Room {function: 'kitchen'}) RETURN g, k",
        "MATCH (g:Room {function: 'garage'})-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-"
        "(k:Room {function: 'kitchen'}) WHERE g.area >= 40 RETURN g.id, k.id",
        "SELECT g.id, k.id FROM room g JOIN opens e ON e.source = g.pk JOIN opening d ON d.pk = e.target "
        "JOIN opens f ON f.target = d.pk JOIN room k ON k.pk = f.source "
        "WHERE g.function = 'garage' AND g.area >= 40 AND d.kind = 'door' AND k.function = 'kitchen'",
        vf2=True,
    ),
    Asked(
        "narrow door between bath and bedroom",
        "selective",
        "MATCH (a:Room {function: 'bath'})-[d:DOOR {width: ..0.65}]-(b:Room {function: 'bedroom'}) "
        "RETURN a, b, d.width",
        "MATCH (a:Room {function: 'bath'})-[:OPENS]->(d:Opening {kind: 'door'})<-[:OPENS]-"
        "(b:Room {function: 'bedroom'}) WHERE d.width <= 0.65 RETURN a.id, b.id, d.width",
        "SELECT a.id, b.id, d.width FROM room a JOIN opens e ON e.source = a.pk JOIN opening d ON d.pk = e.target "
        "JOIN opens f ON f.target = d.pk JOIN room b ON b.pk = f.source "
        "WHERE a.function = 'bath' AND b.function = 'bedroom' AND d.kind = 'door' AND d.width <= 0.65",
        vf2=True,
    ),
    Asked(
        "large terrace on the fourth storey",
        "selective",
        "MATCH (s:Storey {index: 3})-[:HAS_ROOM]->(t:Room {function: 'terrace', area: 40..}) RETURN s, t, t.area",
        "MATCH (s:Storey {index: 3})-[:HAS_ROOM]->(t:Room {function: 'terrace'}) WHERE t.area >= 40 "
        "RETURN s.id, t.id, t.area",
        "SELECT s.id, t.id, t.area FROM storey s JOIN has_room h ON h.source = s.pk JOIN room t ON t.pk = h.target "
        "WHERE s.index = 3 AND t.function = 'terrace' AND t.area >= 40",
    ),
    Asked(
        "two like rooms, one with stairs up",
        "selective",
        "MATCH (a:Room {area: 10..12})-[:DOOR]-(b:Room {area: 10..12}), (b)-[:STAIRS]->(c:Room) RETURN a, b, c",
        "MATCH (b:Room)-[:OPENS]->(:Opening {kind: 'stairs'})<-[:OPENS]-(c:Room) WHERE 10 <= b.area <= 12 "
        "AND c.floor_elevation > b.floor_elevation "
        "MATCH (b)-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(a:Room) WHERE 10 <= a.area <= 12 AND a <> c "
        "RETURN a.id, b.id, c.id",
        vf2=False,
    ),
    Asked(
        "bedroom, hall, kitchen, living room",
        "whole corpus",
        "MATCH (a:Room {function: 'bedroom'})-[:DOOR]-(b:Room {function: 'hall'})-[:DOOR]-"
        "(c:Room {function: 'kitchen'})-[:DOOR]-(d:Room {function: 'living room'}) RETURN a, b, c, d",
        "MATCH (a:Room {function: 'bedroom'})-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(b:Room {function: 'hall'})"
        "-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(c:Room {function: 'kitchen'})"
        "-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(d:Room {function: 'living room'}) "
        "RETURN a.id, b.id, c.id, d.id",
        "SELECT a.id, b.id, c.id, d.id FROM room a JOIN opens ab ON ab.source = a.pk "
        "JOIN opening x ON x.pk = ab.target AND x.kind = 'door' "
        "JOIN opens ba ON ba.target = x.pk JOIN room b ON b.pk = ba.source JOIN opens bc ON bc.source = b.pk "
        "JOIN opening y ON y.pk = bc.target AND y.kind = 'door' JOIN opens cb ON cb.target = y.pk "
        "JOIN room c ON c.pk = cb.source JOIN opens cd ON cd.source = c.pk "
        "JOIN opening z ON z.pk = cd.target AND z.kind = 'door' JOIN opens dc ON dc.target = z.pk "
        "JOIN room d ON d.pk = dc.source WHERE a.function = 'bedroom' AND b.function = 'hall' "
        "AND c.function = 'kitchen' AND d.function = 'living room'",
        vf2=True,
    ),
    Asked(
        "four rooms in a row, by size",
        "whole corpus",
        "MATCH (a:Room {area: 12..20})-[:DOOR]-(b:Room {area: ..8})-[:DOOR]-(c:Room {area: 12..20})-[:DOOR]-"
        "(d:Room {area: 25..}) RETURN a, b, c, d",
        "MATCH (a:Room)-[:OPENS]->(x:Opening {kind: 'door'})<-[:OPENS]-(b:Room)"
        "-[:OPENS]->(y:Opening {kind: 'door'})<-[:OPENS]-(c:Room)-[:OPENS]->(z:Opening {kind: 'door'})<-[:OPENS]-"
        "(d:Room) WHERE 12 <= a.area <= 20 AND b.area <= 8 AND 12 <= c.area <= 20 AND d.area >= 25 AND a <> c "
        "RETURN a.id, b.id, c.id, d.id",
        "SELECT a.id, b.id, c.id, d.id FROM room a JOIN opens ab ON ab.source = a.pk "
        "JOIN opening x ON x.pk = ab.target AND x.kind = 'door' "
        "JOIN opens ba ON ba.target = x.pk JOIN room b ON b.pk = ba.source JOIN opens bc ON bc.source = b.pk "
        "JOIN opening y ON y.pk = bc.target AND y.kind = 'door' JOIN opens cb ON cb.target = y.pk "
        "JOIN room c ON c.pk = cb.source JOIN opens cd ON cd.source = c.pk "
        "JOIN opening z ON z.pk = cd.target AND z.kind = 'door' JOIN opens dc ON dc.target = z.pk "
        "JOIN room d ON d.pk = dc.source WHERE a.area BETWEEN 12 AND 20 AND b.area <= 8 "
        "AND c.area BETWEEN 12 AND 20 AND d.area >= 25 AND a.pk <> c.pk",
        vf2=True,
    ),
    Asked(
        "four rooms in a row, any, counted",
        "whole corpus",
        "MATCH (a:Room)-[:DOOR]-(b:Room)-[:DOOR]-(c:Room)-[:DOOR]-(d:Room) RETURN count(*)",
        "MATCH (a:Room)-[:OPENS]->(x:Opening {kind: 'door'})<-[:OPENS]-(b:Room)"
        "-[:OPENS]->(y:Opening {kind: 'door'})<-[:OPENS]-(c:Room)-[:OPENS]->(z:Opening {kind: 'door'})<-[:OPENS]-"
        "(d:Room) WHERE a <> c AND b <> d AND a <> d AND x <> z AND a.id < d.id RETURN count(*)",
        "SELECT count(*) FROM opens ab JOIN opening x ON x.pk = ab.target AND x.kind = 'door' "
        "JOIN opens ba ON ba.target = x.pk AND ba.source <> ab.source JOIN opens bc ON bc.source = ba.source "
        "AND bc.target <> x.pk JOIN opening y ON y.pk = bc.target AND y.kind = 'door' "
        "JOIN opens cb ON cb.target = y.pk "
        "AND cb.source <> ba.source AND cb.source <> ab.source JOIN opens cd ON cd.source = cb.source "
        "AND cd.target <> y.pk AND cd.target <> x.pk JOIN opening z ON z.pk = cd.target AND z.kind = 'door' "
        "JOIN opens dc ON dc.target = z.pk AND dc.source <> cb.source AND dc.source <> ba.source "
        "AND ab.source < dc.source",
    ),
    Asked(
        "bath inside a bedroom suite",
        "whole corpus",
        "MATCH (h:Room {function: 'hall'})-[:DOOR]-(b:Room {function: 'bedroom'})-[:DOOR]-(w:Room {function: 'bath'}), "
        "(h)-[:DOOR]-(l:Room {function: 'living room'}) WHERE w.area < b.area / 3 RETURN h, b, w, l",
        "MATCH (h:Room {function: 'hall'})-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(b:Room {function: 'bedroom'})"
        "-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(w:Room {function: 'bath'}) WHERE w.area < b.area / 3 "
        "MATCH (h)-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(l:Room {function: 'living room'}) "
        "RETURN h.id, b.id, w.id, l.id",
    ),
    Asked(
        "three rooms in a ring",
        "cyclic",
        "MATCH (a:Room)-[:DOOR]-(b:Room)-[:DOOR]-(c:Room)-[:DOOR]-(a) RETURN a, b, c",
        "MATCH (a:Room)-[:OPENS]->(x:Opening {kind: 'door'})<-[:OPENS]-(b:Room)"
        "-[:OPENS]->(y:Opening {kind: 'door'})<-[:OPENS]-(c:Room)-[:OPENS]->(z:Opening {kind: 'door'})<-[:OPENS]-(a) "
        "WHERE a.id < b.id AND b.id < c.id RETURN a.id, b.id, c.id",
        "SELECT ab.source, ba.source, cb.source FROM opens ab JOIN opening x ON x.pk = ab.target AND x.kind = 'door' "
        "JOIN opens ba ON ba.target = x.pk AND ba.source > ab.source JOIN opens bc ON bc.source = ba.source "
        "JOIN opening y ON y.pk = bc.target AND y.kind = 'door' JOIN opens cb ON cb.target = y.pk "
        "AND cb.source > ba.source JOIN opens ca ON ca.source = cb.source JOIN opening z ON z.pk = ca.target "
        "AND z.kind = 'door' JOIN opens ac ON ac.target = z.pk AND ac.source = ab.source",
        vf2=True,
    ),
    Asked(
        "four rooms in a ring",
        "cyclic",
        "MATCH (a:Room)-[:DOOR]-(b:Room)-[:DOOR]-(c:Room)-[:DOOR]-(d:Room)-[:DOOR]-(a) RETURN a, b, c, d",
        "MATCH (a:Room)-[:OPENS]->(x:Opening {kind: 'door'})<-[:OPENS]-(b:Room)"
        "-[:OPENS]->(y:Opening {kind: 'door'})<-[:OPENS]-(c:Room)"
        "-[:OPENS]->(z:Opening {kind: 'door'})<-[:OPENS]-(d:Room)"
        "-[:OPENS]->(w:Opening {kind: 'door'})<-[:OPENS]-(a) "
        "WHERE a.id < b.id AND a.id < c.id AND a.id < d.id AND b.id < d.id RETURN a.id, b.id, c.id, d.id",
        vf2=True,
    ),
    Asked(
        "bedrooms that share walls with a bath and each other",
        "cyclic",
        "MATCH (a:Room {function: 'bedroom'})-[:NEIGHBOUR]-(b:Room {function: 'bedroom'})-[:NEIGHBOUR]-"
        "(w:Room {function: 'bath'})-[:NEIGHBOUR]-(a) RETURN a, b, w",
        "MATCH (a:Room {function: 'bedroom'})-[:NEIGHBOUR]-(b:Room {function: 'bedroom'})-[:NEIGHBOUR]-"
        "(w:Room {function: 'bath'})-[:NEIGHBOUR]-(a) WHERE a.id < b.id RETURN a.id, b.id, w.id",
        vf2=True,
    ),
    Asked(
        "neighbours with two doors",
        "cyclic",
        "MATCH (a:Room)-[d:DOOR]-(b:Room), (a)-[e:DOOR]-(b) RETURN a, b, d, e",
        "MATCH (a:Room)-[:OPENS]->(d:Opening {kind: 'door'})<-[:OPENS]-(b:Room) "
        "MATCH (a)-[:OPENS]->(e:Opening {kind: 'door'})<-[:OPENS]-(b) WHERE a.id < b.id AND d.id < e.id "
        "RETURN a.id, b.id, d.id, e.id",
    ),
    Asked(
        "from a garage to a bedroom in three doors",
        "paths",
        "MATCH (g:Room {function: 'garage'})-[:DOOR*1..3]-(b:Room {function: 'bedroom'}) RETURN g, b",
        "MATCH (g:Room {function: 'garage'})(()-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-()){1,3}"
        "(b:Room {function: 'bedroom'}) RETURN DISTINCT g.id, b.id",
    ),
    Asked(
        "from a kitchen to a large terrace in four openings",
        "paths",
        "MATCH (k:Room {function: 'kitchen'})-[:OPENING*1..4]-(t:Room {function: 'terrace', area: 80..}) RETURN k, t",
        "MATCH (t:Room {function: 'terrace'}) WHERE t.area >= 80 MATCH (t)(()-[:OPENS]->(:Opening)<-[:OPENS]-()){1,4}"
        "(k:Room {function: 'kitchen'}) RETURN DISTINCT k.id, t.id",
    ),
    Asked(
        "neighbours of neighbours of a large garage",
        "paths",
        "MATCH (g:Room {function: 'garage', area: 50..})-[:NEIGHBOUR*1..2]-(b:Room {function: 'bedroom'}) RETURN g, b",
        "MATCH (g:Room {function: 'garage'})-[:NEIGHBOUR*1..2]-(b:Room {function: 'bedroom'}) WHERE g.area >= 50 "
        "RETURN DISTINCT g.id, b.id",
    ),
    Asked(
        "kitchens without a window",
        "negation",
        "MATCH (k:Room {function: 'kitchen'}) WHERE NOT EXISTS { (k)-[:OPENS]->(:Opening {kind: 'window'}) } RETURN k",
        "MATCH (k:Room {function: 'kitchen'}) WHERE NOT EXISTS { (k)-[:OPENS]->(:Opening {kind: 'window'}) } "
        "RETURN k.id",
        "SELECT id FROM room k WHERE function = 'kitchen' AND NOT EXISTS (SELECT 1 FROM opens e JOIN opening w "
        "ON w.pk = e.target WHERE e.source = k.pk AND w.kind = 'window')",
    ),
    Asked(
        "bedrooms that share a wall and no door",
        "negation",
        "MATCH (a:Room {function: 'bedroom'})-[:NEIGHBOUR]-(b:Room {function: 'bedroom'}) "
        "WHERE NOT EXISTS { (a)-[:DOOR]-(b) } RETURN a, b",
        "MATCH (a:Room {function: 'bedroom'})-[:NEIGHBOUR]-(b:Room {function: 'bedroom'}) WHERE a.id < b.id "
        "AND NOT EXISTS { (a)-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(b) } RETURN a.id, b.id",
        "SELECT a.id, b.id FROM room a JOIN neighbour n ON n.source = a.pk JOIN room b ON b.pk = n.target "
        "WHERE a.function = 'bedroom' AND b.function = 'bedroom' AND NOT EXISTS (SELECT 1 FROM opens e "
        "JOIN opening d ON d.pk = e.target JOIN opens f ON f.target = d.pk "
        "WHERE e.source = a.pk AND f.source = b.pk AND d.kind = 'door')",
    ),
    Asked(
        "large rooms with nothing in them",
        "negation",
        "MATCH (r:Room {area: 20..}) WHERE NOT EXISTS { (r)-[:CONTAINS]->(:Object) } RETURN r",
        "MATCH (r:Room) WHERE r.area >= 20 AND NOT EXISTS { (r)-[:CONTAINS]->(:Object {parts: 1}) } RETURN r.id",
        "SELECT id FROM room r WHERE area >= 20 AND NOT EXISTS (SELECT 1 FROM contains c WHERE c.source = r.pk)",
    ),
    Asked(
        "halls with six doors",
        "negation",
        "MATCH (h:Room {function: 'hall'}) WHERE count { (h)-[:DOOR]-(:Room) } >= 6 RETURN h",
        "MATCH (h:Room {function: 'hall'}) "
        "WHERE COUNT { (h)-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(:Room) } >= 6 RETURN h.id",
    ),
    Asked(
        "areas by function",
        "statistics",
        "MATCH (r:Room) RETURN r.function, count(*), avg(r.area), percentileCont(r.area, 0.5)",
        "MATCH (r:Room) RETURN r.function, count(*), avg(r.area), percentileCont(r.area, 0.5)",
        "SELECT function, count(*), avg(area), quantile_cont(area, 0.5) FROM room GROUP BY 1",
    ),
    Asked(
        "doors a building",
        "statistics",
        "MATCH (d:Opening {kind: 'door'}) RETURN d.building, count(*), min(d.width), max(d.width)",
        "MATCH (d:Opening {kind: 'door'}) RETURN d.building, count(*), min(d.width), max(d.width)",
        "SELECT building, count(*), min(width), max(width) FROM opening WHERE kind = 'door' GROUP BY 1",
    ),
    Asked(
        "rooms and area a storey",
        "statistics",
        "MATCH (s:Storey)-[:HAS_ROOM]->(r:Room) RETURN s.index, count(*), avg(r.area), stDev(r.area)",
        "MATCH (s:Storey)-[:HAS_ROOM]->(r:Room) RETURN s.index, count(*), avg(r.area), stDev(r.area)",
        "SELECT s.index, count(*), avg(r.area), stddev(r.area) FROM storey s JOIN has_room h ON h.source = s.pk "
        "JOIN room r ON r.pk = h.target GROUP BY 1",
    ),
    Asked(
        "objects by function of the room",
        "statistics",
        "MATCH (r:Room)-[:CONTAINS]->(o:Object) RETURN r.function, count(*)",
        "MATCH (r:Room)-[:CONTAINS]->(:Object {parts: 1}) RETURN r.function, count(*)",
    ),
    Asked(
        "what door joins which functions",
        "statistics",
        "MATCH (a:Room)-[d:DOOR]-(b:Room) WHERE a.function < b.function RETURN a.function, b.function, count(*)",
        "MATCH (a:Room)-[:OPENS]->(d:Opening {kind: 'door'})<-[:OPENS]-(b:Room) WHERE a.function < b.function "
        "RETURN a.function, b.function, count(*)",
        "SELECT a.function, b.function, count(*) FROM opening d JOIN opens e ON e.target = d.pk "
        "JOIN opens f ON f.target = d.pk AND f.source <> e.source JOIN room a ON a.pk = e.source "
        "JOIN room b ON b.pk = f.source WHERE d.kind = 'door' AND a.function < b.function GROUP BY 1, 2",
    ),
    Asked(
        "ten objects most like one",
        "likeness",
        "MATCH (o:Object LIKE $basin) RETURN o, score LIMIT 10",
    ),
    Asked(
        "bath with the best likeness, two doors from a kitchen",
        "likeness",
        "MATCH (k:Room {function: 'kitchen'})-[:DOOR]-(h:Room)-[:DOOR]-(w:Room {function: 'bath'})"
        "-[:CONTAINS]->(o:Object LIKE $basin) RETURN k, w, o, score LIMIT 10",
    ),
    Asked(
        "rooms with two such objects",
        "likeness",
        "MATCH (r:Room)-[:CONTAINS]->(o:Object LIKE $basin WITHIN 0.4), "
        "(r)-[:CONTAINS]->(p:Object LIKE $basin WITHIN 0.4) "
        "RETURN r, o, p, score LIMIT 10",
    ),
    Asked(
        "bedrooms without such an object",
        "likeness",
        "MATCH (r:Room {function: 'bedroom', area: 20..}) "
        "WHERE NOT EXISTS { (r)-[:CONTAINS]->(:Object LIKE $basin WITHIN 0.8) } RETURN r",
    ),
)
