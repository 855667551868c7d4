// The room that holds most things, and what stands or hangs in it (single pieces, no combinations)
MATCH (room:Room)-[:CONTAINS]->(object:Object)
WHERE coalesce(object.parts, 1) = 1
WITH room, count(object) AS objects
ORDER BY objects DESC, room.id
LIMIT 1
MATCH way = (room)-[:CONTAINS]->(object:Object)
WHERE coalesce(object.parts, 1) = 1
RETURN way
