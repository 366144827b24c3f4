# Every target makes what it needs, the virtual environment included: `make demo` and `make test` work in a fresh clone.
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

BIN := .venv/bin
STAMP := .venv/stamp
JOBS ?= 2
SCENES ?=
ROBOTS ?=
WITH ?= all
EFFORT ?= quick
PDF ?=
GENERATED ?= generated
PYTEST_ARGS ?=
# One thread per process: the work is spread over processes.
export OMP_NUM_THREADS ?= 1

$(STAMP): requirements/lock.txt requirements/venv.sh pyproject.toml
	@requirements/venv.sh

.PHONY: help
help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1~\2/p' $(MAKEFILE_LIST) | awk -F'~' '{printf "%-18s %s\n", $$1, $$2}'

.PHONY: demo
demo: $(STAMP) ## every example: generate, certify, compile, validate, report (out/demo/index.html)
	@$(BIN)/symgen report $(or $(SCENES),examples/*.scene.yaml) -o out/demo --jobs $(JOBS)

.PHONY: site
site: $(STAMP) ## the whole site of reports, everything measured (WITH=speed, EFFORT=full, PDF=--pdf; out/site/index.html)
	@$(BIN)/symgen report $(or $(SCENES),examples/*.scene.yaml) -o out/site --with $(WITH) --effort $(EFFORT) $(PDF) --jobs $(JOBS)

.PHONY: test
test: $(STAMP) ## the tests (PYTEST_ARGS=--slow for all of them)
	@$(BIN)/python -m pytest -n $(JOBS) $(PYTEST_ARGS)

.PHONY: lint
lint: $(STAMP) ## ruff and mypy --strict
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check --quiet .
	@$(BIN)/mypy

.PHONY: format
format: $(STAMP) ## what ruff can put right by itself
	@$(BIN)/ruff check --fix --quiet .
	@$(BIN)/ruff format --quiet .

.PHONY: bench
bench: $(STAMP) ## speed and error beside the peers that are installed (`make peers`), out/bench; SCENES="ur5 panda"
	@$(BIN)/python -m tools.bench $(SCENES)

.PHONY: work-precision
work-precision: $(STAMP) ## CPU time against error of our integrators beside Exudyn's and Pinocchio's, out/work_precision (SCENES="fig2 panda")
	@$(BIN)/python -m symgen.validation.work_precision --full -o out/work_precision $(or $(SCENES),double_pendulum spinning_top fig1 fig2 panda)

.PHONY: peers
peers: $(STAMP) ## install what `make bench` compiles beside our code, into .venv
	@$(BIN)/python -m pip --disable-pip-version-check install --quiet -r requirements/peers.txt

.PHONY: generated
generated: $(STAMP) ## regenerate generated/ (C, headers and manifests of the examples)
	@$(BIN)/python tools/generated.py --jobs $(JOBS) $(GENERATED)

.PHONY: robots
robots: $(STAMP) ## operations, times and differences to Pinocchio over real robots (ROBOTS="panda hyq", out/robots)
	@$(BIN)/python -m tools.robots $(ROBOTS)

.PHONY: accuracy
accuracy: $(STAMP) ## errors of the examples and five robots against ball arithmetic (SCENES="ur5 panda", out/accuracy)
	@$(BIN)/python -m tools.accuracy $(SCENES)

.PHONY: hard
hard: $(STAMP) ## the hard cases, each beside its right answer
	@$(BIN)/python -m symgen.validation.hard_cases

.PHONY: lock
lock: ## look for newer versions and rewrite requirements/lock.txt
	@requirements/relock.sh

.PHONY: clean
clean: ## remove the virtual environment, out/ and caches
	rm -rf .venv out dist build .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
