# make run and make test are all a bare machine with Python 3.11 to 3.13 needs; each installs what it misses.
SHELL := /bin/sh
.DEFAULT_GOAL := help
.PHONY: help install run test test-slow lint format paper bench wheel clean

ARGS ?=
EXTRAS ?=
VENV := .venv
BIN := $(VENV)/bin
comma := ,
# What running needs, and what developing needs beside it; EXTRAS adds to either.
RUN := $(VENV)/.installed$(addprefix -,$(subst $(comma),-,$(EXTRAS)))
DEV := $(RUN)-dev
# The first interpreter that really starts (a version manager's stand-in may refuse): 3.11, for which alone PyBullet has
# a wheel, then newer ones.
PYTHON ?= $(shell for v in 11 12 13; do for p in python3.$$v /usr/bin/python3.$$v /usr/local/bin/python3.$$v python3 python; do \
	"$$p" -c "import sys, venv, ensurepip; sys.exit(sys.version_info[:2] != (3, $$v))" >/dev/null 2>&1 && { command -v "$$p"; exit; }; done; done)
# Two runs in parallel are faster than one on two threads: the problems are small.
export OMP_NUM_THREADS ?= 1

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z%-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)
	@echo '  settings:   ARGS="object=meat acq.w=2.0"  PYTHON=/path/to/python3.12  EXTRAS=rivals,tune'

install: $(DEV) ## make .venv and install everything in locked versions, tests and linters included

$(RUN): pyproject.toml requirements.lock
	$(call pip,$(EXTRAS))

$(DEV): pyproject.toml requirements.lock
	$(call pip,dev$(addprefix $(comma),$(EXTRAS)))
	@touch $(RUN)

define pip
	@test -n "$(PYTHON)" || { echo "Python 3.11, 3.12 or 3.13 with venv not found: install one, or name it with make PYTHON=/path/to/python3.11" >&2; exit 2; }
	@echo "installing into $(VENV), some minutes (2.6 GB)"
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || "$(PYTHON)" -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint requirements.lock --editable ".$(if $(1),[$(1)])"
	@touch $@
endef

run: $(RUN) ## one run, settings in ARGS
	$(BIN)/python -m deformpush $(ARGS)

test: $(DEV) ## the tests that take seconds
	$(BIN)/python -m pytest -n 2 -m "not slow" $(ARGS)

test-slow: $(DEV) ## physics gates and whole runs, minutes
	$(BIN)/python -m pytest -n 2 -m slow --timeout 1800 $(ARGS)

lint: $(DEV) ## format check, ruff, mypy, spelling
	$(BIN)/python -m ruff format --check .
	$(BIN)/python -m ruff check .
	$(BIN)/python -m mypy
	$(BIN)/python -m codespell_lib

format: $(DEV) ## put the code in form
	$(BIN)/python -m ruff format .
	$(BIN)/python -m ruff check --fix .

paper: $(RUN) ## both scenarios of the paper and their figures
	$(BIN)/python -m deformpush experiment=paper_rect $(ARGS)
	$(BIN)/python -m deformpush experiment=paper_meat $(ARGS)

bench: $(RUN) ## speed, as a table
	$(BIN)/python -m benchmarks $(ARGS)

bench-%: $(RUN) ## one study, as in bench-regret
	$(BIN)/python -m benchmarks.$* $(ARGS)

wheel: $(DEV) ## build dist/*.whl
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .

clean: ## remove the environment, caches and builds, not runs/
	rm -rf $(VENV) dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
