// Rooms with a single way in, and what it is
MATCH (room:Room)-[:OPENS]->(opening:Opening)
WHERE opening.kind <> 'window'
WITH room, collect(opening) AS openings
WHERE size(openings) = 1
RETURN room.building AS building, room.name AS room, round(room.area, 1) AS area_m2,
       openings[0].name AS way_in, round(openings[0].width, 2) AS width_m
ORDER BY building, room
