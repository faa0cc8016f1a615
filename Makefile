# Two commands: `make bench` and `make test`. Each sets up .venv by itself.
PYTHON ?= python3
BIN := .venv/bin
RESULTS ?= $(firstword $(dir $(wildcard results/*/record.jsonl)))

.PHONY: bench test keep emulate clean

bench: .venv/installed
	$(BIN)/thrustbench run

test: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo
	$(BIN)/python -m pytest -n 2

# Makes the last run of `make bench` one to commit: its record packed, README's table out of it.
keep: .venv/installed
	$(BIN)/thrustbench report $(RESULTS) --readme README.md
	gzip --best --no-name --force $(RESULTS)/record.jsonl

# Counts instructions of the generated C on processors that are not here: results/emulated.
emulate: .venv/installed
	$(BIN)/python -m bench.emulation.install
	$(BIN)/thrustbench emulate
	$(BIN)/thrustbench emulate --add --vehicle docs/vehicles/box8.yaml

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[all]'
	touch $@

clean:
	rm -rf .venv build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
