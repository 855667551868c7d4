// All rooms, the largest first
MATCH (storey:Storey)-[:HAS_ROOM]->(room:Room)
RETURN room.building AS building, storey.index AS storey, room.name AS room,
       round(room.area, 1) AS area_m2, round(room.height, 2) AS height_m
ORDER BY area_m2 DESC, building, room
