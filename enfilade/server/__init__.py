"""A real Neo4j on this machine, without Docker, root or a system Java."""
