"""The docker files: nothing open to the world, no password in them, and in step with the rest of the project."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[2]
DOCKER = ROOT / "docker"


@pytest.fixture
def services() -> dict[str, Any]:
    loaded: dict[str, Any] = yaml.safe_load((DOCKER / "compose.yaml").read_text(encoding="utf-8"))
    assert set(loaded) == {"name", "services", "secrets", "volumes"}
    found: dict[str, Any] = loaded["services"]
    return found


def test_ports_are_open_to_this_machine_only(services: dict[str, Any]) -> None:
    ports = [port for service in services.values() for port in service.get("ports", [])]
    assert ports
    assert all(port.startswith("127.0.0.1:") for port in ports)


def test_both_services_share_the_secret_and_no_password_is_written_down(services: dict[str, Any]) -> None:
    assert all(service["secrets"] == ["neo4j_auth"] for service in services.values())
    environments = [name for service in services.values() for name in service["environment"]]
    assert not any("PASSWORD" in name or name.endswith("AUTH") for name in environments)
    assert "neo4j_auth" in (DOCKER / ".gitignore").read_text(encoding="utf-8").splitlines()


def test_the_job_waits_for_neo4j_and_shares_the_scans(services: dict[str, Any]) -> None:
    job = services["job"]
    assert job["depends_on"] == {"neo4j": {"condition": "service_healthy"}}
    assert "healthcheck" in services["neo4j"]
    assert [volume.rpartition(":")[2] for volume in job["volumes"]] == ["/scans"]
    assert "@neo4j:7687" in job["environment"]["ENFILADE_STORE"]


def test_neo4j_is_of_the_line_that_the_tests_run_on(services: dict[str, Any]) -> None:
    pins = (ROOT / "enfilade" / "server" / "jars.tsv").read_text(encoding="utf-8")
    version = next(line.split("\t")[2] for line in pins.splitlines() if line.startswith("org.neo4j\tneo4j\t"))
    assert services["neo4j"]["image"] == f"neo4j:{'.'.join(version.split('.')[:2])}-community"


def test_every_variable_has_a_default() -> None:
    text = (DOCKER / "compose.yaml").read_text(encoding="utf-8")
    assert re.findall(r"\$\{[^}]*\}", text)
    assert all(":-" in variable for variable in re.findall(r"\$\{[^}]*\}", text))


def test_the_image_has_the_system_packages_that_the_project_names() -> None:
    packages = set(re.findall(r"lib[a-z0-9-]+", (DOCKER / "Dockerfile").read_text(encoding="utf-8")))
    named = set(re.findall(r"lib\w+\.so\.\d+:([a-z0-9-]+)", (ROOT / "tools" / "prepare").read_text(encoding="utf-8")))
    assert packages - {"lib"} == named


def test_what_the_image_copies_is_there_and_not_ignored() -> None:
    lines = (DOCKER / "Dockerfile").read_text(encoding="utf-8").splitlines()
    copied = [
        word for line in lines if line.startswith("COPY") for word in line.split()[1:-1] if not word.startswith("-")
    ]
    kept = (DOCKER / "Dockerfile.dockerignore").read_text(encoding="utf-8").splitlines()
    assert all((ROOT / name).exists() and f"!{name}" in kept for name in copied)


def test_the_job_hands_the_password_and_the_words_on(tmp_path: Path) -> None:
    secret = tmp_path / "neo4j_auth"
    secret.write_text("neo4j/pass/word with $signs\n")
    (tmp_path / "enfilade").write_text('#!/bin/sh\nprintf "%s|" "$ENFILADE_PASSWORD" "$@"\n')
    (tmp_path / "enfilade").chmod(0o755)
    script = (DOCKER / "job").read_text(encoding="utf-8").replace("/run/secrets/neo4j_auth", str(secret))
    (tmp_path / "job").write_text(script)
    done = subprocess.run(
        ["sh", tmp_path / "job", "ingest", "a b.e57"],
        env={"PATH": f"{tmp_path}:/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "pass/word with $signs|ingest|a b.e57|"


def test_docker_accepts_the_file() -> None:
    docker = shutil.which("docker")
    if docker is None or subprocess.run([docker, "compose", "version"], capture_output=True, check=False).returncode:
        pytest.skip("docker compose is not installed")
    done = subprocess.run(
        [docker, "compose", "-f", DOCKER / "compose.yaml", "--profile", "job", "config", "--quiet"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
