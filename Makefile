# Camwright. `make` alone prints what there is.

PYTHON ?= python3
ARGS   ?=

# Only `make run HOST=…` counts: many shells export a HOST of their own.
ifneq ($(origin HOST),command line)
HOST := $(or $(CAMWRIGHT_HOST),127.0.0.1)
endif
ifneq ($(origin PORT),command line)
PORT := $(or $(CAMWRIGHT_PORT),8000)
endif

VENV := .venv
PY   := $(VENV)/bin/python
# One stamp for each lock file; what tests need includes what running needs.
RUN  := $(VENV)/.installed-run
DEV  := $(VENV)/.installed-dev
PIP  := $(PY) -m pip install --quiet --quiet --disable-pip-version-check --no-input
LOCK := $(PY) -m uv pip compile --quiet --universal --python-version 3.11 \
        --fork-strategy fewest --strip-extras --no-header --no-annotate --generate-hashes \
        $(if $(UPGRADE),--upgrade)

# What the tests of the contract take from Node.js; no script of a package runs.
NODE := tests/service/contract/node
NPM  := npm ci --ignore-scripts --no-audit --no-fund --loglevel=error

# Whatever virtualenv or Python settings the caller has must not leak into ours.
unexport VIRTUAL_ENV PYTHONHOME PYTHONPATH PYTHONDONTWRITEBYTECODE PIP_USER PIP_TARGET PIP_PREFIX PIP_REQUIREMENT
export PYTHONNOUSERSITE = 1

.DEFAULT_GOAL := help
.PHONY: help run test hard mutants lint format bench gaps openapi contract constants lock sbom audit clean distclean

help:  ## print this list
	@echo "Camwright. Targets:"
	@sed -n 's/^\([a-z]*\):.*## */  make \1|/p' $(firstword $(MAKEFILE_LIST)) \
	  | awk -F'|' '{ printf "%-16s %s\n", $$1, $$2 }'

run: $(RUN)  ## start the service (HOST=127.0.0.1 PORT=8000)
	@CAMWRIGHT_HOST='$(HOST)' CAMWRIGHT_PORT='$(PORT)' $(PY) -m service

# All tests at once, in four parts that take about as long, and lint beside them: those that kill,
# restart and wait leave two cores to the others. What lint says is not asked once more by a test.
PARTS   := waiting service core rest
waiting := $(patsubst %,tests/service/%.py,sweeps/test_kills test_deployment \
             sweeps/test_leases workers/test_trouble test_benchmark \
             resources/test_cam_sets commands/test_sweep_and_export commands/test_commands)
service := $(filter-out $(waiting),$(wildcard tests/service/test_*.py tests/service/*/test_*.py))
arms    := $(wildcard $(patsubst %,tests/pipeline/test_%.py,*arm* oscillating*))
waiting += tests/catalogue tests/exporters tests/machines tests/validation $(arms)
service += tests/certify
core    := tests/checker $(filter-out $(arms),$(wildcard tests/pipeline/test_*.py \
             tests/pipeline/*/test_*.py))
rest    := --ignore=tests/architecture/test_quality.py $(filter-out \
             tests/service tests/pipeline $(waiting) $(service) $(core),$(patsubst %/,%,$(wildcard tests/*/)))
test: $(DEV)  ## run everything: style, types, layers and the tests (ARGS="-k name")
ifneq ($(ARGS),)
	@$(MAKE) --no-print-directory lint
	$(PY) -m pytest $(ARGS)
else
	@$(MAKE) --no-print-directory --keep-going --jobs=5 lint $(PARTS:%=test-%)
endif

# Its output is shown when the part is through. One thread each, as in workers: more than there are
# cores wait for each other at work.
test-%: export OPENBLAS_NUM_THREADS = 1
test-%: $(DEV)
	@$(PY) -m pytest --durations=25 $($*) >$(VENV)/tests-$*.log 2>&1; code=$$?; cat $(VENV)/tests-$*.log; exit $$code

hard: $(DEV)  ## question after question, judged: ARGS=random (the default), loaded, mixed, bounds, transformed, own; ARGS=--help says more
	$(PY) -m tests.hard.run $(ARGS)

mutants: $(DEV)  ## plant faults, see which no test sees, write docs/mutants.md: half an hour (ARGS="--room certify --count 50 --seed 2" only prints)
	$(PY) -m tests.mutants $(or $(ARGS),--write)

lint: $(DEV)  ## style, types and layers only
	$(PY) -m ruff check
	$(PY) -m ruff format --check
	$(PY) -m mypy
	$(VENV)/bin/lint-imports --no-logo

format: $(DEV)  ## put the code in form
	$(PY) -m ruff check --fix
	$(PY) -m ruff format

bench: $(DEV)  ## measure speed and error, print it, write docs/benchmarks and the table of docs/overview.md (ARGS="name" only prints)
	$(PY) -m benchmarks $(or $(ARGS),--write)

gaps: $(DEV)  ## gaps and times of proofs for random scenes of every family, write docs/benchmarks/gaps (ARGS="--scenes 1 --family arm" only prints)
	$(PY) -m benchmarks.gaps $(or $(ARGS),--write)

contract: $(DEV)  ## Redocly's and Spectral's rules over openapi/openapi.json (Spectral is installed on the first call, 70 MB)
	$(PY) -m pytest -q tests/service/contract/test_typescript_client.py -k redocly
	$(NPM) --prefix $(NODE)/spectral
	$(NODE)/spectral/node_modules/.bin/spectral lint --fail-severity=hint \
	  --ruleset $(NODE)/spectral/ruleset.yaml openapi/openapi.json

constants: $(DEV)  ## write docs/constants.md, the numbers of the product with their reasons
	$(PY) -m tests.architecture.constants

openapi: $(DEV)  ## write openapi/openapi.json anew
	$(PY) -m service.openapi

lock: $(DEV)  ## write the lock files anew (UPGRADE=1 takes newer versions)
	$(LOCK) --extra dev pyproject.toml --output-file requirements-dev.lock
	$(LOCK) --constraint requirements-dev.lock --extra dxf pyproject.toml --output-file requirements.lock
	$(LOCK) --constraint requirements-dev.lock --extra dxf --extra parquet --extra postgres \
	  --extra traces pyproject.toml --output-file requirements-image.lock
	@! grep -nE '://|^-|^/|@' requirements.lock requirements-dev.lock requirements-image.lock \
	  || { echo "A lock file holds an address, an option or a path: see above." >&2; exit 1; }

# A project of the locked packages alone: uv exports and audits projects, not lists of packages.
LOCKED := $(VENV)/locked
define locked
@rm -rf $(LOCKED) && mkdir -p $(LOCKED)
@cd $(LOCKED) && ../bin/python -m uv init --quiet --bare --no-workspace --name camwright-locked --python 3.11 . \
  && ../bin/python -m uv add --quiet --no-sync -r ../../requirements-image.lock
endef

sbom: $(DEV)  ## write sbom.json, the packages of the image in CycloneDX, with their hashes
	$(locked)
	@$(PY) -m uv export --quiet --project $(LOCKED) --format cyclonedx1.5 --no-emit-project \
	  --output-file sbom.json >/dev/null && echo "Wrote sbom.json."

audit: $(DEV)  ## ask osv.dev for known faults of the packages of the image (needs the Internet)
	$(locked)
	@$(PY) -m uv audit --project $(LOCKED)

clean:  ## remove caches and build products
	rm -rf build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis \
	  .import_linter_cache .mutants $(NODE)/node_modules $(NODE)/spectral/node_modules
	find . -name __pycache__ -not -path './$(VENV)/*' -type d -prune -exec rm -rf {} +

distclean: clean  ## the same and the virtual environment
	rm -rf $(VENV)

# --- the virtual environment: made once, installed anew only when a lock file changes -----------

# A virtual environment whose interpreter is gone counts as none.
ifeq ($(shell $(PY) -c 'print(1)' 2>/dev/null),)
.PHONY: $(RUN) $(DEV)
endif

define venv
@command -v $(PYTHON) >/dev/null \
  || { echo "Camwright needs Python 3.11 or newer, and '$(PYTHON)' was not found." >&2; exit 1; }
@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
  || { echo "Camwright needs Python 3.11 or newer, and '$(PYTHON)' is $$($(PYTHON) -V 2>&1)." \
            "With a newer one installed: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 1; }
@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
  || { echo "'$(PYTHON)' cannot make virtual environments; on Debian: apt install python3-venv." >&2; \
       exit 1; }
@$(PY) -c '' 2>/dev/null || $(PYTHON) -m venv --clear $(VENV)
endef

define install
@$(PIP) -r $(1) && $(PIP) --no-deps --editable . \
  || { echo "Installing the locked packages failed: see above. Is the package index reachable?" >&2; \
       exit 1; }
endef

$(RUN): requirements.lock
	$(venv)
	@echo "Installing the locked packages into $(VENV): once, 190 MB to fetch, half a minute or more."
	$(call install,requirements.lock)
	@touch $(RUN)

$(DEV): requirements-dev.lock requirements.lock $(NODE)/package-lock.json
	$(venv)
	@echo "Installing the locked packages and the test tools into $(VENV): once, 500 MB to fetch, two minutes or more."
	$(call install,requirements-dev.lock)
	@if command -v npm >/dev/null; then $(NPM) --prefix $(NODE); else \
	  echo "npm was not found: the tests of the TypeScript client will fail. They need Node.js 20.19 or" \
	    "newer; on Debian: apt install nodejs npm; then: npm ci --ignore-scripts --prefix $(NODE)" >&2; fi
	@touch $(RUN) $(DEV)
