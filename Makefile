# `make demo` and `make test` from a bare clone: each sets up .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
DEMO := results/demo

# One thread for BLAS and PyTorch: faster for networks and matrices of this size.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

.PHONY: demo test slow clients lint figures results benchmark peers clean

demo: $(READY)  ## The trained agents and the whole field on 1,000 random rigs
	$(BIN)/python eval.py --suite default --output $(DEMO) --overwrite

test: $(READY) lint  ## Linters, type checker and the fast tests
	$(BIN)/python -m pytest -n 2

slow: $(READY)  ## The tests that take minutes
	$(BIN)/python -m pytest -m slow -n 2

clients: $(READY)  ## The environments with other libraries for reinforcement learning, which it installs
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev,clients]'
	$(BIN)/python -m pytest -m clients

lint: $(READY)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

figures: $(READY)  ## The chapter's figures and the bistable region, from the project's own code
	$(BIN)/python -m drillrig_env.plots

results: $(READY)  ## Every policy on every suite, and the page of results; about a quarter of an hour
	$(BIN)/python eval.py mppi --suite default --output results/state --no-pictures --overwrite
	$(BIN)/python eval.py --output results/state --reference soft_torque --no-pictures --resume
	$(BIN)/python eval.py --env DrillRigSurface-v0 --output results/surface --reference soft_torque --no-pictures --overwrite
	$(BIN)/python -m drillrig_env.evaluation.page results/state results/surface

benchmark: $(READY)  ## Speed beside everything else that is installed, and the page of it; about an hour
	$(BIN)/python -m benchmarks.solvers
	$(BIN)/python -m benchmarks.batches
	$(BIN)/python -m benchmarks.environments
	$(BIN)/python -m benchmarks.startup
	$(BIN)/python -m benchmarks.training
	$(BIN)/python -m benchmarks.stability
	$(BIN)/python -m benchmarks.page

peers: $(READY)  ## The other solvers and environments that `make benchmark` compares with
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[benchmark]'

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt torch
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	touch $(READY)

clean:
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache *.egg-info
