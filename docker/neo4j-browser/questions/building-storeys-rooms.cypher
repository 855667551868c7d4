// A building, its storeys and their rooms
MATCH way = (:Building)-[:HAS_STOREY]->(:Storey)-[:HAS_ROOM]->(:Room)
RETURN way
