"""Random questions about random buildings, a store against the oracle, for as long as one likes.

``python tests/fuzz.py --minutes 10`` (``make fuzz``) asks SQLite, ``--neo4j`` a real Neo4j. Most buildings and
questions are drawn at random, some by hypothesis, which makes what it finds small and tries it first the next time.
The seed of each round is printed, and ``--seed`` goes the same way again.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from hypothesis.database import DirectoryBasedExampleDatabase
from oracle_comparison import ask_and_compare, buildings_and_maker

from enfilade import server
from enfilade.stores import Store, open_store

PLAIN_EXAMPLES = 20
EXAMPLES_A_ROUND = 10
QUESTIONS_AN_EXAMPLE = 20


@contextmanager
def a_store(*, neo4j: bool) -> Iterator[Store]:
    """A store of its own, thrown away at the end."""
    with tempfile.TemporaryDirectory() as folder:
        if not neo4j:
            with open_store(f"sqlite:{folder}/fuzz.db") as store:
                yield store
            return
        home = Path(folder)
        running = server.start(home, settings=server.Settings(bolt_port=0, http_port=0))
        try:
            password = running.password_file.read_text(encoding="utf-8")
            with open_store(running.url, ask=lambda _: password) as store:
                yield store
        finally:
            server.stop(home)


def a_round(store: Store, number: int, asked: list[str]) -> None:
    """Ask some hundred questions; raises AssertionError with the smallest question that is answered wrongly."""

    @seed(number)
    @settings(
        max_examples=EXAMPLES_A_ROUND,
        deadline=None,
        derandomize=False,
        database=DirectoryBasedExampleDatabase(".hypothesis/fuzz"),
        phases=[Phase.reuse, Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
        print_blob=True,
    )
    @given(st.randoms(use_true_random=False))
    def compare(rng: random.Random) -> None:
        oracle, maker = buildings_and_maker(store, rng)
        asked.extend(ask_and_compare(store, oracle, maker.question()) for _ in range(QUESTIONS_AN_EXAMPLE))

    for example in range(PLAIN_EXAMPLES):
        oracle, maker = buildings_and_maker(store, random.Random(f"{number} {example}"))
        asked.extend(ask_and_compare(store, oracle, maker.question()) for _ in range(QUESTIONS_AN_EXAMPLE))
    compare()


def main() -> int:
    """Run rounds until the time is over or one fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument("--neo4j", action="store_true", help="ask a real Neo4j")
    options = parser.parse_args()
    asked: list[str] = []
    end = time.monotonic() + 60 * options.minutes
    number = options.seed
    with a_store(neo4j=options.neo4j) as store:
        try:
            while time.monotonic() < end:
                print(f"seed {number}: ", end="", flush=True)
                a_round(store, number, asked)
                print(f"{len(asked):,} questions so far, {len(set(asked)):,} of them different, all as the oracle")
                number += 1
        except AssertionError as error:
            print(f"differs from the oracle: {error}\nagain with --seed {number}")
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
