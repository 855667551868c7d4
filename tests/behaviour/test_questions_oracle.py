"""Random questions about random buildings, every store against the oracle: the same rows in the same order.

`tests/fuzz.py` (``make fuzz``) asks many more.
"""

from __future__ import annotations

import os
import random
from collections.abc import Iterator

import pytest
from oracle_comparison import ask_and_compare, buildings_and_maker

from enfilade.stores import Store, open_store

QUESTIONS_A_SEED = 25
SQLITE_SEEDS = int(os.environ.get("ENFILADE_FUZZ_SEEDS", "100"))
NEO4J_SEEDS = int(os.environ.get("ENFILADE_FUZZ_NEO4J_SEEDS", "10"))


@pytest.fixture(scope="module")
def worn_store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    """A store whose buildings are replaced again and again."""
    with open_store(f"sqlite:{tmp_path_factory.mktemp('worn') / 'enfilade.db'}") as store:
        yield store


@pytest.mark.parametrize("seed", range(SQLITE_SEEDS))
def test_sqlite_answers_as_the_oracle(worn_store: Store, seed: int) -> None:
    compare_with_oracle(worn_store, seed)


@pytest.mark.neo4j
@pytest.mark.parametrize("seed", range(1000, 1000 + NEO4J_SEEDS))
def test_neo4j_answers_as_the_oracle(neo4j_store: Store, seed: int) -> None:
    compare_with_oracle(neo4j_store, seed)


def compare_with_oracle(store: Store, seed: int) -> None:
    rng = random.Random(seed)
    oracle, maker = buildings_and_maker(store, rng)
    for _ in range(QUESTIONS_A_SEED):
        ask_and_compare(store, oracle, maker.question())
