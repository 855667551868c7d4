"""Enfilade: registered indoor laser scans in, a graph of rooms out, questions over many buildings answered."""

from importlib.metadata import version

__version__ = version("enfilade")
