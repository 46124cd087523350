# make all   install into .venv, then regenerate results/table1.csv on the embedded benchmark
# make test  install with the test extra, then linters, type checker and the test suite
PYTHON ?= python3.11
CORES ?= 2
BIN := .venv/bin
SOURCES := pyproject.toml setup.py $(wildcard src/r3gw/*/csrc/*)

.PHONY: all ablations test lint clean

all: .venv/installed
	$(BIN)/snakemake --cores $(CORES) all

ablations: .venv/installed
	$(BIN)/snakemake --cores $(CORES) ablations

test: .venv/installed-test lint
	$(BIN)/python -m pytest

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow

.venv/bin/python:
	$(PYTHON) -m venv .venv

# torch comes first, because building the C++ extension needs the very torch that runs it.
.venv/installed: .venv/bin/python $(SOURCES)
	$(BIN)/pip install --quiet --disable-pip-version-check \
		torch==2.13.0 setuptools==84.2.1 ninja==1.13.2 numpy==2.4.6
	$(BIN)/pip install --quiet --disable-pip-version-check --no-build-isolation --editable .
	touch $@

.venv/installed-test: .venv/installed
	$(BIN)/pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[test]'
	touch $@

clean:
	rm -rf results logs .snakemake
