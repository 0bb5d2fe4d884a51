# make demo   everything that is needed, then a call on this machine
# make test   the same, then the tests
# make check  the tests and everything else that CI runs
# make api    pages from the docstrings, in build/api
# make doctor what works on this machine and what does not

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.PHONY: demo test check lint doctor api system system-test models clean

demo: system $(STAMP) models
	$(BIN)/conf demo $(ARGS)

test: system-test $(STAMP) models
	$(BIN)/python -m pytest $(ARGS)

check: test lint

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

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

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "conf needs Python 3.11 or newer: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) \
	  || { echo "no venv module: type  apt-get install python3-venv"; exit 1; }
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $(STAMP)

clean:
	rm -rf $(VENV) build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
