# make all   install into .venv, then regenerate results/table1.csv on the embedded benchmark
# make test  install with the test extra, then linters, type checker and the test suite
# make test-quick  the tests that are not marked slow: for every edit, about a minute
PYTHON ?= python3.11
CORES ?= 2
BIN := .venv/bin
SOURCES := pyproject.toml setup.py src/r3gw/native/build.py $(wildcard src/r3gw/*/csrc/* src/r3gw/*/*/csrc/*)

.PHONY: all ablations test test-quick lint fuzz sanitize clean

all: .venv/installed
	$(BIN)/snakemake --cores $(CORES) all

ablations: .venv/installed
	$(BIN)/snakemake --cores $(CORES) ablations

test: .venv/installed-test lint
	$(BIN)/python -m pytest

test-quick: .venv/installed-test
	$(BIN)/python -m pytest -m "not slow"

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy benchmarks/*.py
	$(BIN)/snakefmt --check Snakefile workflow

# Mutated files through every reader; ends with an error and lists them if there are faults.
INPUTS ?= 100000
fuzz: .venv/installed-test
	PYTHONPATH=src:tests $(BIN)/python -m support.fuzzing --inputs $(INPUTS)

# The kernels' tests under the address and undefined-behaviour sanitizers, in a copy of the package.
SANITIZED := build/sanitize
sanitize: .venv/installed-test
	R3GW_SANITIZE=1 $(BIN)/python setup.py -q build_ext \
		--build-temp $(SANITIZED)/temp --build-lib $(SANITIZED)/lib
	rm -rf $(SANITIZED)/package && mkdir -p $(SANITIZED)/package
	cp -r src/r3gw $(SANITIZED)/package/
	cp $(SANITIZED)/lib/r3gw/_C.*.so $(SANITIZED)/package/r3gw/
	LD_PRELOAD="$$(c++ -print-file-name=libasan.so) $$(c++ -print-file-name=libubsan.so)" \
	ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
	PYTHONPATH=$(SANITIZED)/package $(BIN)/python -m pytest -p no:cacheprovider \
		tests/raster tests/training tests/model tests/rendering

.venv/bin/python:
	$(PYTHON) -m venv .venv

# torch comes first, because building the C++ extension needs the very torch that runs it.
.venv/installed: .venv/bin/python $(SOURCES)
	$(BIN)/pip install --quiet --disable-pip-version-check \
		torch==2.13.0 setuptools==84.2.1 ninja==1.13.2 numpy==2.4.6
	$(BIN)/pip install --quiet --disable-pip-version-check --no-build-isolation --editable .
	touch $@

# The test extra alone: asking pip for '.[test]' would compile the extension a second time.
.venv/installed-test: .venv/installed
	$(BIN)/pip install --quiet --disable-pip-version-check $$($(BIN)/python -c "import tomllib; \
		project = tomllib.load(open('pyproject.toml', 'rb'))['project']; \
		print(*project['optional-dependencies']['test'])")
	touch $@

clean:
	rm -rf results logs .snakemake
