// The two rooms that lie farthest apart, counted in openings, and the way between them
MATCH (a:Room)
MATCH (b:Room {building: a.building})
WHERE a.id < b.id
MATCH way = shortestPath((a)-[:OPENS*..40]-(b))
RETURN way
ORDER BY length(way) DESC, a.id, b.id
LIMIT 1
