// Storeys of all buildings: rooms, area, doors a room
MATCH (storey:Storey)-[:HAS_ROOM]->(room:Room)
OPTIONAL MATCH (room)-[:OPENS]->(door:Opening {kind: 'door'})
WITH storey, room, count(door) AS doors
RETURN storey.building AS building, storey.index AS storey, count(room) AS rooms,
       round(sum(room.area), 1) AS area_m2, round(avg(doors), 1) AS doors_a_room
ORDER BY building, storey
