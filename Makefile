# Two commands do all set-up on a fresh machine with Python 3.11 or newer:
#   make demo    makes an environment in .venv, renders the demo strip into demo/
#   make test    adds what the tests need, then formatting, lint, types and tests
# Both need the network the first time only.

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

.PHONY: help demo test format bench clean

help:
	@sed -n '2,4s/^# *//p' Makefile

demo: $(VENV)/.installed
	$(BIN)/gonio demo

test: $(VENV)/.installed-test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/pytest

format: $(VENV)/.installed-test
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(VENV)/.installed
	$(BIN)/gonio bench --output docs/performance.md

$(VENV)/bin/python:
	PYTHON=$(PYTHON) sh .ci/system-packages
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "gonio needs Python 3.11 or newer; set PYTHON=python3.x")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(INSTALL) -e .
	touch $@

$(VENV)/.installed-test: $(VENV)/.installed
	PYTHON=$(PYTHON) sh .ci/system-packages g++
	$(INSTALL) -e '.[test]'
	touch $@

clean:
	rm -rf $(VENV) demo build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
