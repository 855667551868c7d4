// Rooms that share a wall but no opening: where a new door could go
MATCH way = (a:Room)-[wall:NEIGHBOUR]-(b:Room)
WHERE a.id < b.id AND NOT EXISTS { (a)-[:OPENS]->(:Opening)<-[:OPENS]-(b) }
RETURN way
