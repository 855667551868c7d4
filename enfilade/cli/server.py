"""``enfilade server``: a real Neo4j with its Browser on this machine."""
