# Two commands: `make bench` and `make test`. Each sets up .venv by itself, as do the others.
PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt
RUN ?= $(patsubst %/record.jsonl,%,$(wildcard runs/*/record.jsonl runs/*/*/record.jsonl))

.PHONY: bench test types pytest docs elsewhere keep emulate prove clean

bench: .venv/lean
	$(BIN)/thrustbench run

test: .venv/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo
	@$(MAKE) --no-print-directory --jobs 2 --keep-going types pytest

types: .venv/test
	$(BIN)/mypy

pytest: .venv/test
	$(BIN)/python -m pytest -n 2 --dist loadfile $(OPTIONS)

# The documentation as a site, links checked: build/site/index.html.
docs: .venv/docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet

# The tests as somebody else's machine runs them: make elsewhere WHERE="user shuffled"; .ci/elsewhere says what.
elsewhere: .venv/test
	.ci/elsewhere $(WHERE) -- -q

# Puts a run, runs/<machine>/<date and time>, into results/<machine>, to be committed: its record packed, its
# report, and README's table if it has times.
keep: KEPT = results/$(if $(filter runs/%,$(RUN)),$(word 2,$(subst /, ,$(RUN))),$(notdir $(RUN:/=)))
keep: .venv/lean
	$(if $(wildcard $(addsuffix /record.jsonl,$(RUN))),,$(error no run in $(or $(RUN),runs/); `make bench` makes one))
	$(if $(word 2,$(RUN)),$(error several runs: make keep RUN=... with one of $(RUN)))
	mkdir -p $(KEPT)
	rm -f $(KEPT)/*.svg
	gzip --best --no-name --stdout $(RUN)/record.jsonl > $(KEPT)/record.jsonl.gz
	$(BIN)/thrustbench report $(KEPT) $(if $(wildcard $(RUN)/results.csv),--readme README.md)

# Counts instructions of the generated C on processors that are not here: runs/emulated.
emulate: .venv/rivals
	$(BIN)/python -m bench.chips.install
	$(BIN)/python -m alloc.rivals.download
	$(BIN)/thrustbench emulate
	$(BIN)/thrustbench emulate --add --vehicle docs/vehicles/box8.yaml

# Proves all generated C, and that each way to break it is found (docs/proof.md): runs/proof.
prove: .venv/prove
	$(BIN)/python -m bench.chips.install
	$(BIN)/python -m bench.proof.install
	$(BIN)/thrustbench prove --thorough --out runs/proof/double
	$(BIN)/thrustbench prove --thorough --float --out runs/proof/float
	$(BIN)/thrustbench prove --library --out runs/proof/library
	$(BIN)/python docs/studies/sabotage.py

# What the main job needs, and no more.
.venv/lean: pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(PIP) --editable '.[solvers]'
	touch $@

# One more extra each, the name of which is the file's: .venv/test, .venv/docs, .venv/prove, .venv/rivals, .venv/all.
.venv/%: .venv/lean
	$(PIP) --editable '.[$*]'
	touch $@

clean:
	rm -rf .venv build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
