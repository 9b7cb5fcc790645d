# `make help` lists what can be made, and the names of claims, benchmarks and pictures.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
STUBS := typings/mujoco-stubs

# Names are the files of a folder; those that begin with an underscore are shared. A file of claims
# has variants: CLAIM_REST of imu.py is imu-rest.
names = $(subst _,-,$(filter-out _% test_%,$(basename $(notdir $(sort $(wildcard tests/$(1)/*.py))))))
claims = $(shell grep -o '^CLAIM[A-Z0-9_]* =' tests/claims/*.py | sed 's|.*/||; s| =||; s|.py:CLAIM||' | tr A-Z_ a-z- | sort)

.PHONY: help run test docs mutants claims bench pages pictures calibration contract house release releasable clean
.DELETE_ON_ERROR:

run: $(VENV)/.installed
	$(BIN)/armside laser

help:
	@echo 'make run                  set up and cut the default circle'
	@echo 'make test                 set up and check everything'
	@echo 'make docs                 the pages of docs/ and of the API as HTML, in build/docs'
	@echo 'make mutants              deliberate faults that the tests notice: docs/mutation.md, hours'
	@echo 'make claims   [NAME=...] [SEEDS=n] [SEED=first]   claims over seeds: docs/claims, hours'
	@echo 'make bench    [NAME=...]  seconds on this machine, beside other libraries if installed'
	@echo 'make pages    [NAME=...]  the numbers of README and docs, by their commands'
	@echo 'make pictures [NAME=...]  the pictures of the docs: docs/images'
	@echo 'make calibration [GENERATIONS=n]   the unknown numbers of the large robot'
	@echo 'make house                size and structure of the project: docs/house.md'
	@echo 'make contract [LINES=n]   command lines at random, held against the contract'
	@echo 'make release              archive and wheel in dist/, checked, from a clean tree'
	@echo
	@echo 'Claims:     $(claims)' | fold -sw 100
	@echo 'Benchmarks: $(call names,benchmarks)' | fold -sw 100
	@echo 'Pictures:   $(call names,gallery)' | fold -sw 100

claims: $(VENV)/.installed-test
	$(BIN)/python -m tests.claims $(NAME) $(if $(SEEDS),--seeds $(SEEDS)) $(if $(SEED),--seed $(SEED))

bench: $(VENV)/.installed-test
	$(BIN)/python -m tests.benchmarks $(NAME)

pages: $(VENV)/.installed-test
	$(BIN)/python -m tests.pages $(NAME)

pictures: $(VENV)/.installed-test
	$(BIN)/python -m tests.gallery $(NAME)

house: $(VENV)/.installed-test
	$(BIN)/python -m tests.house $(if $(SECONDS_OF_SUITE),--seconds $(SECONDS_OF_SUITE))

calibration: $(VENV)/.installed
	$(BIN)/python -m tests.calibration $(if $(GENERATIONS),--generations $(GENERATIONS))

contract: $(VENV)/.installed-test
	$(BIN)/python -m tests.contract $(if $(LINES),--lines $(LINES))

test: $(VENV)/.installed-test $(STUBS)/py.typed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/python -m pytest -n auto --dist worksteal

docs: $(VENV)/.installed-docs
	$(BIN)/python -m sphinx -W --keep-going -E docs build/docs

version := $(shell sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)

release: releasable $(VENV)/.installed-release
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/python -m twine check --strict dist/*

releasable:
	@changes=$$(git status --porcelain) && test -z "$$changes" || { echo "release: git status shows changes; commit them first" >&2; exit 1; }
	@grep -q '^## \[$(version)\] - ' CHANGELOG.md || { echo "release: CHANGELOG.md has no heading '## [$(version)] - DATE'" >&2; exit 1; }

# A virtual environment without a working pip was left by an interrupted set-up: start it afresh.
$(VENV)/.installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("armside needs Python 3.11 or newer" if sys.version_info < (3, 11) else 0)'
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear $(VENV)
	@echo "Installing into $(VENV) ..."
	$(PIP) install --editable .
	@touch $@

$(VENV)/.installed-test: $(VENV)/.installed
	@echo "Installing what the tests need ..."
	$(PIP) install --editable '.[test]'
	@touch $@

$(VENV)/.installed-release: $(VENV)/.installed
	$(PIP) install --editable '.[release]'
	@touch $@

mutants: $(VENV)/.installed-test
	$(BIN)/python -m tests.mutation run --generic 40
	$(BIN)/python -m tests.mutation page --generic 40

$(VENV)/.installed-docs: $(VENV)/.installed
	$(PIP) install --editable '.[docs,tuning]'
	@touch $@

# MuJoCo ships no type information: pyright reads what its compiled modules say of themselves.
$(STUBS)/py.typed: $(VENV)/.installed-test
	rm -rf typings
	$(BIN)/python -m pybind11_stubgen --ignore-all-errors --output-dir typings \
	  $(addprefix mujoco._,callbacks constants enums errors functions rollout specs structs)
	mv typings/mujoco $(STUBS)
	@echo partial >$@

clean:
	rm -rf $(VENV) typings runs build dist .pytest_cache .hypothesis .ruff_cache
