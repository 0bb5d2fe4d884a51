# make demo    everything that is needed, then a call on this machine
# make test    the same, then the tests
# make quick   the tests without the slow ones: half a minute on two cores
# make check   the tests with their coverage, and everything else that CI runs
# make mutate  mutation testing of modules, each with its own test: make mutate ARGS="protocol/session/sequence face/deformation"
# make api     pages from the docstrings, in build/api
# make doctor  what works on this machine and what does not

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
PYTEST := $(BIN)/python -m pytest -n auto
# twice --quiet: errors only
PIP := $(BIN)/python -m pip install --quiet --quiet --disable-pip-version-check --constraint constraints.txt
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.PHONY: demo test quick check lint mutate doctor api system system-test models clean

demo: system $(STAMP) models
	$(BIN)/conf demo $(ARGS)

test: system-test $(STAMP) models
	$(PYTEST) $(ARGS)

quick: $(STAMP)
	$(PYTEST) -m "not slow" $(ARGS)

check: ARGS += --cov
check: test lint

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy --platform win32 --no-warn-unreachable conf

mutate: $(STAMP)
	$(PIP) --editable '.[mutation]'
	$(BIN)/python tools/mutation/run.py $(ARGS)

doctor: $(STAMP)
	$(BIN)/conf doctor

api: $(STAMP)
	$(BIN)/python tools/docs/api.py

models: $(STAMP)
	@$(BIN)/conf models fetch

system:
	@sh tools/system_packages.sh

system-test:
	@sh tools/system_packages.sh --test

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "conf needs Python 3.11 or newer: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) \
	  || { echo "no venv module: type  apt-get install python3-venv"; exit 1; }
	@echo "installing conf and its packages into $(VENV), which takes a minute or two"
	@$(PIP) --upgrade pip
	@$(PIP) --editable '.[dev]'
	@$(BIN)/python -m compileall -q conf # pip compiles what it copies, and not this; commands start .2 s sooner
	@$(BIN)/python tools/packaging/shell_files.py $(VENV) # an editable installation leaves them out
	@touch $(STAMP)

clean:
	rm -rf $(VENV) build *.egg-info .coverage .mypy_cache .ruff_cache .pytest_cache .hypothesis
