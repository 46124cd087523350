# make all   install into .venv, then regenerate results/table1.csv on the embedded benchmark
# make test  install with the test extra, then linters, type checker and the test suite
# make levels    the kernels' tests for every level of processors that a wheel is made for
# make wheel     a source distribution and a wheel that runs on any such machine, in dist/
# make site      the documentation as a site, in build/site
# make schemas   workflow/schemas from the settings' types
# make kill-test   kills every stage of a small workflow, and compares what comes out in the end
# make cluster-test  the workflow on a Slurm of two nodes, started for it (as root, with Debian's Slurm)
# make test-quick  the tests that are not marked slow: for every edit, about a minute
PYTHON ?= python3.11
CORES ?= 2
BIN := .venv/bin
SOURCES := pyproject.toml constraints.txt setup.py src/r3gw/native/build.py src/r3gw/native/levels.py \
	$(wildcard src/r3gw/*/csrc/* src/r3gw/*/*/csrc/*)

# Snakemake and pip want a home that they can write to, and a name. Who has none, such as the user of
# a container, gets them here.
ifneq ($(shell test -n "$$HOME" && test -d "$$HOME" && test -w "$$HOME" && echo yes),yes)
export HOME := $(CURDIR)/.home
$(shell mkdir -p "$(CURDIR)/.home")
endif
ifneq ($(shell id -un >/dev/null 2>&1 && echo yes),yes)
export LOGNAME ?= nobody
endif

.PHONY: all ablations test test-quick kill-test cluster-test fuzz lint levels wheel site schemas \
	sanitize constraints clean

all: .venv/installed
	$(BIN)/snakemake --cores $(CORES) all

ablations: .venv/installed
	$(BIN)/snakemake --cores $(CORES) ablations

# Whole files of tests go to one process, so that what a file prepares is prepared once.
PYTEST := $(BIN)/python -m pytest --numprocesses $(CORES) --dist loadfile
test: .venv/installed-test lint
	$(PYTEST)

test-quick: .venv/installed-test
	$(PYTEST) -m "not slow"

ROUNDS ?= 1
kill-test: .venv/installed
	$(BIN)/python benchmarks/kill_test.py --rounds $(ROUNDS)

cluster-test: .venv/installed-test
	$(BIN)/python -m pytest tests/cluster

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy benchmarks/*.py
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint

# Mutated files through every reader; ends with an error and lists them if there are faults.
INPUTS ?= 100000
fuzz: .venv/installed-test
	PYTHONPATH=src:tests $(BIN)/python -m support.fuzzing --inputs $(INPUTS)

KERNEL_TESTS := tests/raster tests/training tests/model tests/rendering

# The kernels' tests under the address and undefined-behaviour sanitizers, in a copy of the package.
SANITIZED := build/sanitize
sanitize: .venv/installed-test
	R3GW_SANITIZE=1 R3GW_KERNELS=native $(BIN)/python setup.py -q build_ext \
		--build-temp $(SANITIZED)/temp --build-lib $(SANITIZED)/lib
	rm -rf $(SANITIZED)/package && mkdir -p $(SANITIZED)/package
	cp -r src/r3gw $(SANITIZED)/package/
	rm -f $(SANITIZED)/package/r3gw/_C*.so
	cp $(SANITIZED)/lib/r3gw/_C.*.so $(SANITIZED)/package/r3gw/
	LD_PRELOAD="$$(c++ -print-file-name=libasan.so) $$(c++ -print-file-name=libubsan.so)" \
	ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
	PYTHONPATH=$(SANITIZED)/package $(BIN)/python -m pytest -p no:cacheprovider \
		$(KERNEL_TESTS)

# The kernels' tests at every level of x86-64 that a wheel holds, as far as this processor has it,
# in a copy of the package. Elsewhere: LEVELS=generic.
LEVELS ?= v2 v3 v4
LEVELLED := build/levels
levels: .venv/installed-test
	R3GW_KERNELS="$(LEVELS)" $(BIN)/python setup.py -q build_ext \
		--build-temp $(LEVELLED)/temp --build-lib $(LEVELLED)/lib
	rm -rf $(LEVELLED)/package && mkdir -p $(LEVELLED)/package
	cp -r src/r3gw $(LEVELLED)/package/
	rm -f $(LEVELLED)/package/r3gw/_C*.so
	cp $(LEVELLED)/lib/r3gw/_C_*.so $(LEVELLED)/package/r3gw/
	for level in $(LEVELS); do \
		R3GW_KERNELS=$$level PYTHONPATH=$(LEVELLED)/package \
			$(BIN)/python -m pytest -p no:cacheprovider tests/native $(KERNEL_TESTS) || exit; \
	done

wheel: .venv/installed
	rm -rf build/wheel
	$(BIN)/python setup.py -q sdist --dist-dir build/wheel
	$(BIN)/pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist build/wheel/*.tar.gz
	mv build/wheel/*.tar.gz dist/

.venv/bin/python:
	$(PYTHON) -m venv .venv

# The versions of constraints.txt. torch comes first, because building the C++ extension needs the
# very torch that runs it.
PIP := $(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt
.venv/installed: .venv/bin/python $(SOURCES)
	@echo "Installing PyTorch into .venv: pip says nothing for some minutes."
	$(PIP) torch setuptools ninja numpy
	@echo "Installing all other libraries and compiling the kernels: again some minutes."
	$(PIP) --no-build-isolation --editable '.[pipeline,benchmark,view,cluster]'
	touch $@

LIST_EXTRA := import sys, tomllib; \
	project = tomllib.load(open('pyproject.toml', 'rb'))['project']; \
	print(*project['optional-dependencies'][sys.argv[1]])

# The test extra alone: asking pip for '.[test]' would compile the extension a second time.
.venv/installed-test: .venv/installed
	$(PIP) $$($(BIN)/python -c "$(LIST_EXTRA)" test)
	touch $@

schemas: .venv/installed
	$(BIN)/python -m r3gw.pipeline.schema workflow/schemas

# A warning, a link that leads nowhere and a page that is in no menu are errors.
site: .venv/installed
	$(PIP) $$($(BIN)/python -c "$(LIST_EXTRA)" docs)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

# After a change of versions: what is installed now becomes what everybody installs.
constraints: .venv/installed-test site
	(sed '/^[^#]/d' constraints.txt; \
		$(BIN)/pip freeze --all --exclude-editable --exclude pip | sed 's/+cpu$$//') > constraints.new
	mv constraints.new constraints.txt

clean:
	rm -rf results logs .snakemake
