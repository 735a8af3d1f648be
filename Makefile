# Two commands do everything, set-up included: `make`, which names the next command, and `make test`.
# Only Python >= 3.11 and make are needed; PYTHON=... chooses another interpreter, with an environment of its own.

PYTHON ?= python3
ifeq ($(PYTHON),python3)
VENV := .venv
else
VENV := .venv-$(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])')
endif
BIN := $(VENV)/bin
EXTRAS := dev,dask,dxf,excel,rl,serve
READY := $(VENV)/.ready-$(EXTRAS)
SOURCES := desim_warehouse tests benchmarks studies docs
# Tests of a file share its fixtures, in one of two processes. Files in their order: else those of few dear tests are last.
TWO := -n 2 --dist loadfile --no-loadscope-reorder

# What Python compiled is kept, whatever the shell says: pip, linters and tests are dozens of programs.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: start ready paper test quick quick-tests pythons lowest lint tests test-long docs release-check bench bench-long allocation-table validation pictures clean

start: $(READY)  ## set up, and say what comes next
	@echo "$$($(BIN)/desim --version) is in $(BIN). Next:"
	@echo
	@echo "    source $(BIN)/activate"
	@echo "    desim new mine.yaml --size 30x20 --orders 90/h"

paper: $(READY)  ## the paper's 30 cells: T, S, C beside its figures, tables and figures in reports/out/paper
	$(BIN)/desim paper --out reports/out/paper

test: $(READY)  ## lint, types, layers, all tests
	@echo "lint, types, layers and all tests take minutes; tests say at their end how much processor time they took (make quick: half a minute)"
	@$(MAKE) --no-print-directory --jobs 2 lint tests

quick: $(READY)  ## the inner loop: ruff, and the quick tests of models, layouts, policies and the world
	$(BIN)/ruff check $(SOURCES)
	@$(MAKE) --no-print-directory quick-tests

quick-tests: $(READY)
	$(BIN)/python -m pytest $(TWO) -m "not long and not slow" --exitfirst $(PYTEST) \
	    tests/model tests/orders tests/bad tests/layout tests/policies tests/world tests/golden

pythons:  ## the quick tests on each other Python, 3.11 to 3.14, that is here
	@for python in $$(.ci/pythons); do $(MAKE) --no-print-directory quick-tests PYTHON=$$python EXTRAS=test || exit 1; done

lowest:  ## the quick tests with the lowest versions that pyproject.toml allows; old packages may say that they are old
	mkdir -p build
	sed -n '/^dependencies = /,/^test = /p' pyproject.toml | grep -oE '[a-z.0-9-]+>=[0-9.]+' | sed 's/>=/==/' > build/lowest.txt
	@$(MAKE) --no-print-directory quick-tests VENV=.venv-lowest EXTRAS=test,dxf,excel \
	    PIP="--constraint build/lowest.txt" PYTEST="-W ignore::DeprecationWarning"

lint: $(READY)
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m docs.make_cost --check

tests: $(READY)
	$(BIN)/python -m pytest $(TWO) -m "not long"

test-long: $(READY)  ## slow proofs: thousands of random warehouses
	HYPOTHESIS_PROFILE=long $(BIN)/python -m pytest -n 2 --dist worksteal  # by tests: some files take an hour

docs: $(READY)  ## the site, in build/site: open build/site/index.html
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet

release-check: $(READY)  ## before a release: version, changelog, site, wheel and sdist, lowest versions
	@version=$$($(BIN)/desim --version | sed 's/.* //'); \
	case $$version in *dev*) echo "desim_warehouse/_version.py: $$version is a version under way"; exit 1; esac; \
	grep -q "^## $$version$$" CHANGELOG.md || { echo "CHANGELOG.md: no heading '## $$version'"; exit 1; }; \
	grep -q "^version: $$version$$" CITATION.cff || { echo "CITATION.cff: its version is not $$version"; exit 1; }
	@$(MAKE) --no-print-directory docs lowest
	$(BIN)/python -m pytest tests/cli/test_package.py

bench: $(READY)  ## what people wait for, and speed as ratios to bare SimPy, measured in one process
	$(BIN)/python -m benchmarks

bench-long: $(READY)  ## the same, with what takes minutes: large floors and fleets, a whole shift, how each part grows
	$(BIN)/python -m benchmarks --long

allocation-table: $(READY)  ## the table of allocation strategies in docs/allocation.md
	$(BIN)/python -m benchmarks.allocation

validation: $(READY)  ## docs/dev/validation.md: the simulation against theory, in about ten minutes
	$(BIN)/python -m docs.make_validation

pictures: $(READY)  ## the pictures in docs/pictures
	$(BIN)/python docs/make_pictures.py
	$(BIN)/python docs/make_throughput.py
	$(BIN)/python docs/make_welch.py

ready: $(READY)

$(READY): pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "Python >= 3.11 is needed; make PYTHON=python3.12 chooses another")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile $(PIP) --editable ".[$(EXTRAS)]"  # Python compiles what is imported
	touch $(READY)

clean:
	find desim_warehouse tests benchmarks docs -name __pycache__ -prune -exec rm -rf {} +
	rm -rf .venv* reports/out dist build .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
