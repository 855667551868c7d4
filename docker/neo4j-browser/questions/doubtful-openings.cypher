// Openings that deserve a look: closed ones, and those that little speaks for
MATCH (room:Room)-[:OPENS]->(opening:Opening)
WHERE opening.state = 'closed' OR opening.confidence < 0.7
RETURN opening.building AS building, opening.name AS opening, opening.kind AS kind, opening.state AS state,
       round(opening.confidence, 2) AS confidence, collect(room.name) AS rooms
ORDER BY confidence, building, opening
