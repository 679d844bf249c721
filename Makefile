# Two commands for a fresh machine: "make demo" and "make test". Both make their own .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: demo test notebooks benchmarks clean

demo: $(VENV)/.installed
	$(BIN)/contactqp compare examples/hexagon.toml --plot hexagon.png

test: $(VENV)/.installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest

notebooks: $(VENV)/.installed-test
	$(BIN)/python notebooks/execute.py

benchmarks: $(VENV)/.installed-test
	$(BIN)/python benchmarks/facade.py
	$(BIN)/python benchmarks/psor.py
	$(BIN)/python benchmarks/speed.py
	$(BIN)/python benchmarks/certificates.py
	$(BIN)/python benchmarks/relaxation.py

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "contactqp needs Python 3.11 or newer; run: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

$(VENV)/.installed-test: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	touch $@ $(VENV)/.installed

clean:
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis hexagon.png
	find src tests -name __pycache__ -prune -exec rm -rf {} +
