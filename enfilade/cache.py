"""Where files lie that can be made again."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from platformdirs import user_cache_path

CACHE_VARIABLE: Final = "ENFILADE_CACHE"


def cache_folder() -> Path:
    """Folder of everything that can be made again: ``ENFILADE_CACHE``, or the user's own cache folder."""
    given = os.environ.get(CACHE_VARIABLE)
    return Path(given) if given else user_cache_path("enfilade")
