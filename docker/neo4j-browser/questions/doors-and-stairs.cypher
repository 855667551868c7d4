// How the rooms hang together: every opening between two rooms
MATCH way = (:Room)-[:OPENS]->(:Opening)<-[:OPENS]-(:Room)
RETURN way
