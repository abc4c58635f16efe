# You need Python 3.11 or newer, git and make. Everything else is installed into .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
RUNNABLE := .make/runnable
READY := .make/ready
INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps
STAMP = $(PYTHON) -c 'import pathlib, sys; at = pathlib.Path(sys.argv[1]); at.parent.mkdir(exist_ok=True); at.touch()'
PYTEST = $(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

.PHONY: help dev demo test golden lint format schemas bench docs docs-serve package release-check clean test-unit test-docs test-nightly torture soak coverage audit lock

help:  ## List the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 16

$(RUNNABLE): pyproject.toml requirements-run.lock
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "hmrsim needs Python 3.11 or newer; choose one with make PYTHON=…" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --no-compile --require-hashes -r requirements-run.lock
	$(INSTALL) --no-build-isolation --editable .
	@$(STAMP) $@

$(READY): $(RUNNABLE) requirements.lock
	$(INSTALL) --require-hashes -r requirements.lock
	$(BIN)/python -m pip check --quiet --disable-pip-version-check
	@$(STAMP) $@

dev: $(READY)  ## Set up the development environment

demo: $(RUNNABLE)  ## Run the main job: a hospital mission, simulator and controller as two processes
	$(BIN)/hmrsim demo

test: $(READY)  ## Run every test, or some with ARGS="-k cancel"
	$(PYTEST) $(ARGS)

test-unit: $(READY)  ## Run the tests that need only their own process, in about a minute
	$(PYTEST) tests/unit $(ARGS)

test-docs: $(READY)  ## Run each code block of the documentation and compare its output
	$(BIN)/python -m pytest -n auto --dist load tests/docs $(ARGS)

test-nightly: $(READY)  ## Run the hypothesis tests with many more examples
	HYPOTHESIS_PROFILE=nightly $(PYTEST) -m hypothesis --timeout 14400 $(ARGS)

torture: $(READY)  ## Send a million malformed requests, damage 100,000 files, compare monitors, repeat 1,000 controllers
	$(BIN)/python -m tests.torture.requests $(ARGS)
	$(BIN)/python -m tests.torture.files $(ARGS)
	$(BIN)/python -m tests.torture.monitors $(ARGS)
	$(BIN)/python -m tests.torture.async_controllers --count 1000

soak: $(READY)  ## Run random clients for an hour, and fail if memory grows or answers slow down
	$(BIN)/python -m tests.torture.soak $(ARGS)

coverage: $(READY)  ## Run every test, and fail below the coverage required in pyproject.toml
	$(PYTEST) --cov --cov-report=term:skip-covered $(ARGS)

golden: $(READY)  ## Compare golden runs with the stored results; ARGS="--help" explains how to see the first difference
	$(BIN)/python -m tests.golden $(ARGS)

lint: $(READY)  ## Check style, types and the direction of imports
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/deptry .
	$(BIN)/python -m hmrsim_zenoh.schemas --check
	$(BIN)/python -m tools.event_tables --check
	$(BIN)/python -m tools.settings --check
	$(BIN)/python -m tools.asks --check
	$(BIN)/python -m tools.explanations --check
	$(BIN)/python -m tools.commands --check
	$(BIN)/python -m tools.world_keys --check
	$(BIN)/python -m tools.sbom --check
	$(BIN)/python -m tools.notebook --check
	$(BIN)/zizmor --offline --quiet .github
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.dependabot .github/dependabot.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.github-issue-forms \
		$(filter-out %/config.yml,$(wildcard .github/ISSUE_TEMPLATE/*.yml))
	$(BIN)/check-jsonschema --builtin-schema vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff
	$(BIN)/python -m tools.late_attributes
	$(BIN)/codespell
	$(BIN)/python -m tools.prose

format: $(READY)  ## Format the code, and fix what ruff can fix
	$(BIN)/ruff check --fix-only --quiet .
	$(BIN)/ruff format .

schemas: $(READY)  ## Regenerate schemas/ and the generated tables in docs/
	$(BIN)/python -m hmrsim_zenoh.schemas
	$(BIN)/python -m tools.event_tables
	$(BIN)/python -m tools.settings
	$(BIN)/python -m tools.asks
	$(BIN)/python -m tools.explanations
	$(BIN)/python -m tools.commands
	$(BIN)/python -m tools.world_keys
	$(BIN)/python -m tools.sbom
	$(BIN)/python -m tools.notebook

docs: $(READY)  ## Build the documentation site into .make/site, and fail at a dead link
	$(BIN)/python -m tools.site

docs-serve: $(READY)  ## Show the site at localhost:8000, and rebuild it at each change
	$(BIN)/python -m tools.site --prepare && $(BIN)/zensical serve $(ARGS)

bench: $(READY)  ## Run the benchmarks and print tables, or some with ARGS="scale --quick"
	$(BIN)/python -m benchmarks $(ARGS)

package: $(READY)  ## Build the wheel and the source distribution
	$(BIN)/python -m build

release-check: $(READY)  ## Build the release twice, compare the builds, install one in an empty environment and try it
	$(BIN)/python -m tools.release

audit: $(READY)  ## Look up known vulnerabilities of the locked dependencies, if an index answers
	@{ $(PYTHON) -m venv .make/audit && .make/audit/bin/python -m pip install --quiet --disable-pip-version-check \
		'pip-audit>=2.9,<3'; } 2>.make/audit.log || { echo "not audited: $$(tail -n 1 .make/audit.log)"; exit 0; }; \
		.make/audit/bin/python -m tools.audit

COMPILE = uv pip compile pyproject.toml --universal --python-version 3.11 --generate-hashes \
	--no-header --no-annotate --no-emit-index-url --quiet

lock:  ## Update the lock files, with hashes; needs uv
	$(COMPILE) --all-extras --group dev --output-file requirements.lock
	$(COMPILE) --group editable --constraint requirements.lock --output-file requirements-run.lock

clean:  ## Remove everything that make has created
	rm -rf $(VENV) .make build dist .coverage* .mypy_cache .ruff_cache .pytest_cache
