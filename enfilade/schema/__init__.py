"""What the graph is: nodes, edges, properties, keys, versions."""
