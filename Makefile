# One set of commands for laptops and CI. `make run` and `make test` set up all they need.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: run demo test chromium screenshots check format lint types bench drill clean

# Where CI is set nobody looks: the page is opened, looked at by a browser if there is one, and closed again.
run: $(STAMP)
	$(BIN)/footscan serve --demo --data out/demo-data $(if $(CI),--check --port 0)

demo: $(STAMP)
	$(BIN)/footscan demo --out out/demo

# Tests that need the wall clock or a port share one of the two workers (tests/conftest.py); then the browser has the
# computer for itself: without a graphics card it draws on the processor, and a page that waits too long is tried again.
test: $(STAMP) chromium
	$(BIN)/pytest -n 2 --dist loadgroup -m "not slow and not hardware and not bench and not browser" tests
	$(BIN)/pytest --reruns 2 -m "browser and not slow" tests

chromium:
	@.ci/chromium

screenshots: $(STAMP) chromium
	$(BIN)/footscan screenshots --out docs/pictures

check: lint types

lint: $(STAMP)
	$(BIN)/ruff format --check footscan tests
	$(BIN)/ruff check footscan tests
	$(BIN)/lint-imports

types: $(STAMP)
	$(BIN)/basedpyright

format: $(STAMP)
	$(BIN)/ruff format footscan tests
	$(BIN)/ruff check --fix footscan tests

bench: $(STAMP)
	$(BIN)/footscan bench stripe
	$(BIN)/footscan bench tables
	$(BIN)/footscan bench process
	$(BIN)/footscan bench foot
	$(BIN)/footscan bench session
	$(BIN)/footscan bench lasts
	$(BIN)/footscan bench calibration

drill: $(STAMP)
	$(BIN)/footscan drill --rounds 3
	$(BIN)/footscan drill --rig configs/rig-emulated.toml
	$(BIN)/footscan drill records
	$(BIN)/footscan study motion --scans 40
	$(BIN)/footscan study lasts
	$(BIN)/footscan study machines --count 20

clean:
	rm -rf $(VENV) out

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --upgrade pip
	$(BIN)/pip install --quiet --editable '.[dev]'
	touch $@
