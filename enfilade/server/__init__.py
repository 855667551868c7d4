"""A real Neo4j on this machine, without Docker, root or a system Java."""

from __future__ import annotations

from enfilade.cache import cache_folder

from .home import USER
from .launch import Settings
from .process import ServerStatus, local_password, start, status, stop

__all__ = ["USER", "ServerStatus", "Settings", "cache_folder", "local_password", "start", "status", "stop"]
