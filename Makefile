# Two commands for a fresh machine: "make demo" and "make test". Both make their own .venv; "make help" lists the others.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

# The day that "make minimums" goes back to: all that is not declared in pyproject.toml is as new as it was then, so that
# releases made since cannot break old ones. A lower bound that is raised to a later release moves it.
MINIMUMS_DAY := 2025-12-01
MINIMUMS := .venv-minimums

FAST := -m pytest -m "not slow"

# Tests that run at a time: on few cores more of them would take each other's time, which some tests measure. They start
# a hundred programs, which find the package's bytecode also where Python is told to write none.
WORKERS ?= 2
SIDE_BY_SIDE := -m pytest --numprocesses $(WORKERS) --dist worksteal
DOWNLOADS := --no-python-downloads --quiet

.PHONY: demo help test lint types tests minimums matrix wheel sdist-test notebooks docs benchmarks benchmarks-smoke news clean

demo: $(VENV)/.installed  ## Compare the backends on the hexagon and draw hexagon.png
	$(BIN)/contactqp compare examples/hexagon.toml --plot hexagon.png

help:  ## List the targets
	@grep -E '^[a-z-]+:.*  ## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*  ## (.*)/\1|\2/' | \
		while IFS='|' read -r target text; do printf 'make %-17s %s\n' "$$target" "$$text"; done

test: lint types tests  ## Everything that must pass before a change is merged, but for "make minimums"

lint: $(VENV)/.installed-dev  ## Style, format, spelling and the layers of the package
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell
	$(BIN)/lint-imports

types: $(VENV)/.installed-dev  ## Types
	$(BIN)/mypy

tests: $(VENV)/.installed-dev  ## All tests, the code of README, docs/ and docstrings, and the notebooks
	PYTHONDONTWRITEBYTECODE= $(BIN)/python $(SIDE_BY_SIDE)

minimums: $(MINIMUMS)/.installed  ## The fast tests with every dependency at the lowest version that pyproject.toml allows
	NUMBA_CACHE_DIR=$(CURDIR)/$(MINIMUMS)/numba $(MINIMUMS)/bin/python $(FAST)

matrix: $(VENV)/.installed-dev  ## The fast tests with every Python that is found; make matrix VERSIONS="3.12 3.13" takes these
	$(BIN)/python tools/matrix.py $(VERSIONS)

wheel: $(VENV)/.installed-release  ## Build wheel and sdist into dist/, check both, and run the wheel's command
	rm -rf dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/twine check --strict dist/*
	$(BIN)/check-wheel-contents dist/*.whl
	$(BIN)/uv tool run $(DOWNLOADS) --python $(BIN)/python --isolated --from dist/*.whl contactqp backends

sdist-test: wheel  ## Unpack the sdist elsewhere and run its own fast tests there
	folder=$$(mktemp -d) && trap 'rm -rf "$$folder"' EXIT && \
	tar xzf dist/*.tar.gz -C "$$folder" --strip-components 1 && \
	$(BIN)/uv venv $(DOWNLOADS) --python $(BIN)/python "$$folder/.venv" && \
	$(BIN)/uv pip install --quiet --python "$$folder/.venv/bin/python" --editable "$$folder[test]" && \
	cd "$$folder" && .venv/bin/python $(FAST)

notebooks: $(VENV)/.installed-dev  ## Execute the notebooks anew and keep their outputs
	$(BIN)/python notebooks/execute.py

docs: $(VENV)/.installed-docs  ## Build the documentation site into build/site, where it needs no network
	$(BIN)/sphinx-build --nitpicky --fail-on-warning --keep-going --jobs 2 --doctree-dir build/doctrees docs build/site

benchmarks: $(VENV)/.installed-benchmarks  ## Measure all that benchmarks/ describes, in an hour or more, into build/benchmarks
	$(BIN)/contactqp bench run benchmarks/*.py --out build/benchmarks

benchmarks-smoke: $(VENV)/.installed-benchmarks  ## Run every benchmark once at a small size, to see that it runs
	$(BIN)/contactqp bench run benchmarks/*.py --smoke

news: $(VENV)/.installed-release  ## Show what changelog.d/ will add to the changelog
	$(BIN)/towncrier build --draft --version "$$($(BIN)/python -c 'import contactqp; print(contactqp.__version__)')"

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "contactqp needs Python 3.11 or newer; run: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

$(VENV)/.installed-dev: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable '.[test]' --group dev
	touch $@ $(VENV)/.installed

$(VENV)/.installed-release: $(VENV)/.installed-dev
	$(BIN)/python -m pip install --quiet --group release
	touch $@

$(VENV)/.installed-docs: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	touch $@ $(VENV)/.installed

$(VENV)/.installed-benchmarks: $(VENV)/.installed-dev
	$(BIN)/python -m pip install --quiet --editable '.[benchmarks]'
	touch $@

# Python 3.11, where it is found, or what was asked for: newer ones have no wheels of releases so old.
$(MINIMUMS)/.installed: $(VENV)/.installed-dev pyproject.toml Makefile
	oldest=$(if $(filter file,$(origin PYTHON)),$$($(BIN)/uv python find --system $(DOWNLOADS) 3.11 || echo $(PYTHON)),$(PYTHON)) && \
	$(BIN)/uv venv $(DOWNLOADS) --clear --python "$$oldest" $(MINIMUMS)
	$(BIN)/uv pip install --quiet --python $(MINIMUMS)/bin/python --resolution lowest-direct \
		--exclude-newer $(MINIMUMS_DAY) --editable '.[test]'
	touch $@

clean:  ## Remove what the other targets made
	rm -rf .venv .venv-* build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis hexagon.png
	rm -rf docs/notebooks docs/api/generated docs/pictures docs/_extra docs/_unreleased.md
	find src tests -name __pycache__ -prune -exec rm -rf {} +
