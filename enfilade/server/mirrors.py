"""Where Maven Central is reached from here, as the user's own Maven would."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from enfilade.errors import ServerError


def mirrors_of_central(settings: Path | None = None) -> dict[str, str] | None:
    """Return the first mirror of Maven Central in Maven's settings, or None where Central is asked itself.

    Parameters
    ----------
    settings
        The file, by default ``~/.m2/settings.xml``; it may be missing.
    """
    path = settings or Path.home() / ".m2" / "settings.xml"
    if not path.exists():
        return None
    try:
        root = ElementTree.parse(path).getroot()  # noqa: S314 (the user's own file)
    except ElementTree.ParseError as error:
        raise ServerError(f"{path}, which says where Neo4j's jars come from, is no XML ({error})") from error
    for mirror in root.iterfind(".//{*}mirrors/{*}mirror"):
        url = mirror.findtext("{*}url", "").strip()
        if url and _covers_central(mirror.findtext("{*}mirrorOf", "")):
            return {"central": url.rstrip("/")}
    return None


def _covers_central(pattern: str) -> bool:
    parts = [part.strip() for part in pattern.split(",")]
    return "!central" not in parts and not {"*", "central", "external:*"}.isdisjoint(parts)
