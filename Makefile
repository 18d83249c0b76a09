# Every verb of the project; `make` alone lists them. A fresh machine needs python3 (3.11 or newer, with venv) and make.

PYTHON ?= python3
JOBS ?= 2
BIN := .venv/bin
SYNCED := .venv/.synced
# uv brings its own certificates; where Debian keeps the machine's, it takes those, as a company's proxy needs.
UV := $(BIN)/uv $(if $(wildcard /etc/ssl/certs/ca-certificates.crt),--system-certs)

# Compiled once, tests and package start faster, in all of their processes.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help venv reproduce full lab-study test coverage check fast mutations faults margins lab types style lock clean

help: ## list these verbs
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

venv: $(SYNCED) ## build .venv from requirements.lock, with fledge in it
	@true

reproduce: $(SYNCED) ## run the study in brief and write report/index.html
	$(BIN)/fledge reproduce --out report

full: $(SYNCED) ## run the whole study (half an hour) and write report-full/index.html
	$(BIN)/fledge reproduce --full --out report-full

lab-study: $(SYNCED) ## fly the lab's twin with the policy of make reproduce (quarter of an hour), write report-lab/index.html
	$(BIN)/fledge lab-study report/policies/primitive.onnx --out report-lab

test: $(SYNCED) ## run every test
	@$(BIN)/python -m pytest -n $(JOBS)

# To trace lines makes flights in plain Python three times as long.
coverage: $(SYNCED) ## run every test with lines traced (an hour); fail below 95 % of them covered
	$(BIN)/python -m pytest -n $(JOBS) --timeout 900 --cov --cov-report=term --cov-fail-under=95

check: $(SYNCED) ## look at style and types and run the fast tests, in under two minutes
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	@$(MAKE) --no-print-directory --jobs 2 types fast

fast: $(SYNCED) ## run the fast tests
	@$(BIN)/python -m pytest -n $(JOBS) -m "not slow"

mutations: $(SYNCED) ## delete each clause of the nets; a test must fail every time (half an hour)
	$(BIN)/python tests/mutate.py

faults: $(SYNCED) ## fly every fault by the hundred (ten minutes) and write the matrix into docs/safety-case.md
	$(BIN)/python benchmarks/faults.py

margins: $(SYNCED) ## measure how much of the net's margin is needed (an hour) for docs/safety-case.md
	$(BIN)/python benchmarks/margins.py --json benchmarks/margins.json --figure docs/pictures/sharpness.png

lab: $(SYNCED) ## fly 1,000 flights in the lab's twin behind each of two nets (an hour and a half)
	$(BIN)/python benchmarks/lockstep.py --json benchmarks/lockstep.json

types: $(SYNCED) ## check types
	$(BIN)/pyright

style: $(SYNCED) ## format the code and mend what can be mended
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

lock: | $(BIN)/uv ## write requirements.lock anew from pyproject.toml (UPGRADE=--upgrade takes newer versions)
	$(UV) pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest --generate-hashes \
	  --no-emit-index-url --no-header $(UPGRADE) --all-extras --group dev --output-file requirements.lock pyproject.toml

clean: ## remove .venv, caches and builds; reports stay
	rm -rf .venv .coverage .coverage.* .hypothesis .pytest_cache .ruff_cache build dist
	find src tests -name __pycache__ -prune -exec rm -rf {} +

$(SYNCED): requirements.lock pyproject.toml | $(BIN)/uv
	$(UV) pip sync --quiet --python $(BIN)/python --require-hashes requirements.lock
	$(UV) pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation --editable .
	@touch $@

$(BIN)/uv:
	@$(PYTHON) -c 'import sys; sys.exit("fledge needs Python 3.11 or newer" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv .venv
	sed -n '/^uv==/,/# via/p' requirements.lock | \
	  $(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement /dev/stdin
