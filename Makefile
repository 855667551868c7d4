VENV ?= .venv
BIN := $(VENV)/bin
ENFILADE := $(BIN)/enfilade
FUZZ_MINUTES ?= 20

.DEFAULT_GOAL := help
.PHONY: help install demo test test-fast fuzz check format docs constraints wheel clean

help:  ## say what can be made
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

$(VENV)/.ready: pyproject.toml constraints.txt tools/prepare
	@tools/prepare $(VENV)

install: $(VENV)/.ready  ## make the virtual environment with all that is needed

demo: $(VENV)/.ready  ## simulate, ingest, ask and draw the built-in building
	$(ENFILADE) demo

test: $(VENV)/.ready  ## run all tests; starts a real Neo4j by itself
	$(BIN)/pytest

test-fast: $(VENV)/.ready  ## run the tests that need no server and little time
	$(BIN)/pytest -m 'not neo4j and not slow'

fuzz: $(VENV)/.ready  ## ask both stores random questions beside the oracle, FUZZ_MINUTES=20 each
	$(BIN)/python tests/fuzz.py --minutes $(FUZZ_MINUTES)
	$(BIN)/python tests/fuzz.py --minutes $(FUZZ_MINUTES) --neo4j

check: $(VENV)/.ready  ## lint, types, and whether the generated pages are current
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m enfilade.schema.reference --check docs/graph.md

format: $(VENV)/.ready  ## format the code
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: demo  ## write the generated pages anew, and the output shown in all pages
	$(BIN)/python -m enfilade.schema.reference docs/graph.md
	$(BIN)/python tools/console_blocks.py . README.md docs/*.md

constraints:  ## renew constraints.txt from the newest versions that the bounds allow
	python3 -m venv .constraints-venv
	.constraints-venv/bin/python -m pip install --quiet '.[dev]'
	.constraints-venv/bin/python -m pip freeze --exclude enfilade > constraints.txt
	rm -rf .constraints-venv

wheel: $(VENV)/.ready  ## build wheel and source archive into dist/
	$(BIN)/python -m build

clean:  ## remove what the commands above made, but not the virtual environment
	rm -rf build dist demo enfilade.db enfilade.db-wal enfilade.db-shm enfilade.clouds
	rm -rf .mypy_cache .ruff_cache .pytest_cache .hypothesis
