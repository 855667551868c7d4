// The rooms that most other rooms open to: corridors and halls
MATCH (hub:Room)-[:OPENS]->(:Opening)<-[:OPENS]-(other:Room)
WITH hub, count(DISTINCT other) AS rooms
WHERE rooms >= 3
MATCH way = (hub)-[:OPENS]->(:Opening)<-[:OPENS]-(:Room)
RETURN way
