"""Scans in, one building's graph out."""
