# make run: set up and cut the default circle.  make test: set up and check everything.
# make docs: the pages of docs/ and of the API as HTML, in build/docs.
# make mutants: how many deliberate faults the tests notice, and docs/mutation.md; an hour or two.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
STUBS := typings/mujoco-stubs

.PHONY: run test docs mutants clean
.DELETE_ON_ERROR:

run: $(VENV)/.installed
	$(BIN)/armside laser

test: $(VENV)/.installed-test $(STUBS)/py.typed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/python -m pytest -n auto --dist worksteal

docs: $(VENV)/.installed-docs
	$(BIN)/python -m sphinx -q -W --keep-going -E docs build/docs

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
