"""Where graphs live: SQLite, the embedded default, and Neo4j."""
