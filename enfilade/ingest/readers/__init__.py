"""Scan files in: one module a format, chosen by suffix."""
