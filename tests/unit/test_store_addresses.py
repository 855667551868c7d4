"""From the address of a store to the store, or to a sentence that says what is wrong with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from enfilade.errors import StoreError
from enfilade.stores import open_store


@pytest.fixture(autouse=True)
def no_password(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("ENFILADE_PASSWORD", raising=False)
    monkeypatch.setenv("ENFILADE_CACHE", str(tmp_path / "cache"))


@pytest.mark.parametrize("form", ["sqlite:{}", "{}"])
def test_a_path_is_a_sqlite_store(tmp_path: Path, form: str) -> None:
    with open_store(form.format(tmp_path / "a.db")) as store:
        assert store.dialect == "sql"
        assert store.url == f"sqlite:{tmp_path / 'a.db'}"


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("mysql://host/db", '"mysql://" is no kind of store'),
        ("sqlite:", "lacks the path"),
        ("neo4j://user:secret@host", "a password does not belong into an address"),
        ("neo4j://", "names no host"),
        ("bolt://host:port", "no right port"),
        ("neo4j://host:99999", "no right port"),
        ("neo4j://neo4j@127.0.0.1:7687", "needs a password"),
    ],
)
def test_an_address_without_sense_is_said(url: str, said: str) -> None:
    with pytest.raises(StoreError, match=said) as caught:
        open_store(url)
    assert "secret" not in str(caught.value)


def test_the_one_who_asks_hears_the_address(monkeypatch: pytest.MonkeyPatch) -> None:
    heard = []

    def ask(url: str) -> str:
        heard.append(url)
        return "password"

    with pytest.raises(StoreError, match="cannot be reached"):
        open_store("bolt://me@127.0.0.1:9", ask=ask)
    assert heard == ["bolt://me@127.0.0.1:9"]
    monkeypatch.setenv("ENFILADE_PASSWORD", "password")
    with pytest.raises(StoreError, match="cannot be reached"):
        open_store("bolt://me@127.0.0.1:9", ask=ask)
    assert len(heard) == 1
