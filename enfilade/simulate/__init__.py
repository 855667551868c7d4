"""A virtual terrestrial laser scanner: building model in, E57 scans and ground truth out."""
