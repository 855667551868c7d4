// Doors that a wheelchair does not pass: less than 80 cm wide
MATCH (a:Room)-[:OPENS]->(door:Opening {kind: 'door'})<-[:OPENS]-(b:Room)
WHERE door.width < 0.8 AND a.id < b.id
RETURN door.building AS building, door.name AS door, round(door.width, 2) AS width_m, a.name AS from, b.name AS to
ORDER BY width_m, building, door
