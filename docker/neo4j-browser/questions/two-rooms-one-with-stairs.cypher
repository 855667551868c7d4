// The paper's kind of question: two rooms of 10 to 20 m² joined by a door, one of them with stairs
MATCH way = (a:Room)-[:OPENS]->(:Opening {kind: 'door'})<-[:OPENS]-(b:Room)-[:OPENS]->(:Opening {kind: 'stairs'})
WHERE 10 <= a.area <= 20 AND 10 <= b.area <= 20 AND a <> b
RETURN way
