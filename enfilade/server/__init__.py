"""A real Neo4j on this machine, without Docker, root or a system Java."""

from __future__ import annotations

from .home import USER, cache_folder
from .launch import Settings
from .process import ServerStatus, local_password, start, status, stop

__all__ = ["USER", "ServerStatus", "Settings", "cache_folder", "local_password", "start", "status", "stop"]
