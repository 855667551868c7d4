"""Settings that all tests share."""

from __future__ import annotations

from hypothesis import settings

# The first call of a compiled function takes long, and a run must be repeatable.
settings.register_profile("enfilade", deadline=None, derandomize=True)
settings.load_profile("enfilade")
