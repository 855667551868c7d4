"""Writes ``jars.tsv`` anew from a folder in repository layout, for whoever raises the version of Neo4j.

``mvn dependency:copy-dependencies -DincludeScope=runtime -Dmdep.useRepositoryLayout=true`` makes such a folder
from a POM that asks for ``org.neo4j:neo4j`` and ``org.neo4j.client:neo4j-browser``; then
``python -m enfilade.server.pin FOLDER > enfilade/server/jars.tsv``.
"""

from __future__ import annotations

import sys
from pathlib import Path

from enfilade.server.jars import Jar, sha256_of


def pin(folder: Path) -> list[Jar]:
    """Return the jars below a folder in repository layout (``group/artifact/version/file``), sorted."""
    jars = []
    for path in sorted(folder.rglob("*.jar")):
        *group, artifact, version, name = path.relative_to(folder).parts
        classifier = name.removesuffix(".jar").removeprefix(f"{artifact}-{version}").removeprefix("-")
        jars.append(Jar(".".join(group), artifact, version, classifier, sha256_of(path)))
    return jars


if __name__ == "__main__":
    sys.stdout.writelines("\t".join(jar) + "\n" for jar in pin(Path(sys.argv[1])))
