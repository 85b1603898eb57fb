# Everything needs only Python 3.11 or 3.12 and make; the environment is set up in .venv on first use.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: demo cell-demo test slow fuzz mutants drift lint check clean

$(VENV)/ready: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(0 if (3, 11) <= sys.version_info[:2] <= (3, 12) else "Python 3.11 or 3.12 is needed: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	touch $@

demo: $(VENV)/ready
	$(BIN)/stretch-bt run palpate_stiffness --scene water_balloon

cell-demo: $(VENV)/ready
	$(BIN)/python benchmarks/palpate_wired.py

test: $(VENV)/ready
	$(BIN)/python -m pytest -n auto --dist loadfile

slow: $(VENV)/ready
	$(BIN)/python -m pytest -m slow -s

# draws hard inputs until the time is over or a property breaks
MINUTES ?= 60
fuzz: $(VENV)/ready
	$(BIN)/python benchmarks/fuzz.py --minutes $(MINUTES)

# changes one place of the code at a time, and says which changes no hard case notices
mutants: $(VENV)/ready
	$(BIN)/python benchmarks/mutants.py

# a million ticks, a hundred thousand presses and ten thousand revolutions: what must stay the same, memory and time a step among it
drift: $(VENV)/ready
	$(BIN)/python benchmarks/drift.py

lint: $(VENV)/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

check: lint test

clean:
	rm -rf $(VENV) build dist
