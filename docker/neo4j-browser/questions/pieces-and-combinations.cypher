// A thing that scanning broke into pieces: single segments and the combinations made of them
MATCH (combination:Object)
WHERE combination.parts > 1
WITH combination
ORDER BY combination.parts DESC, combination.id
LIMIT 1
MATCH way = (:Room)-[:CONTAINS]->(:Object)-[:PART_OF]->(combination)
RETURN way
