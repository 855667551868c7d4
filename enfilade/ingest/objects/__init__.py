"""Objects: what stands or hangs in a room, in segments and combinations, with descriptors (§6)."""

from enfilade.ingest.objects.find import find_objects
from enfilade.ingest.objects.parameters import ObjectParameters

__all__ = ["ObjectParameters", "find_objects"]
