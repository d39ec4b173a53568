# Every target sets up what it needs in .venv; the second run finds it there.
# Another interpreter: make PYTHON=python3.12 test

PYTHON ?= python3
JOBS ?= auto
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed-dev
INSTALLED_BENCHMARK := $(VENV)/.installed-benchmark
INSTALLED_DOCS := $(VENV)/.installed-docs
PIP_INSTALL = $(BIN)/python -m pip --disable-pip-version-check install --quiet --editable

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo chapter test check slow bench docs clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-7s %s\n", $$1, $$2 }' Makefile

demo: $(INSTALLED) ## draw the chapter's demonstration into demo-output
	$(BIN)/nonsmooth chapter demo --out demo-output

chapter: $(INSTALLED) ## draw and judge the whole chapter into chapter-output/report.html
	$(BIN)/nonsmooth chapter run --all --out chapter-output

test: $(INSTALLED) ## run the tests and the examples in docstrings
	$(BIN)/nonsmooth warmup
	$(BIN)/python -m pytest --numprocesses=$(JOBS)

check: $(INSTALLED) ## style, format, types, imports, spelling, house tests
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell
	$(BIN)/python -m pytest tests/house

slow: $(INSTALLED) ## run the long checks
	$(BIN)/python -m pytest --numprocesses=$(JOBS) -m slow

bench: $(INSTALLED_BENCHMARK) ## run the benchmarks
	$(BIN)/python benchmarks

docs: $(INSTALLED_DOCS) ## build the documentation site into docs-output; a warning or a broken link is an error
	$(BIN)/sphinx-build -b html -E -d docs-output/doctrees -j auto -n -W --keep-going docs \
	    docs-output/html
	$(BIN)/python docs/links.py docs-output/html

clean: ## remove all that these targets made, .venv included
	rm -rf $(VENV) build dist demo-output chapter-output benchmark-output docs-output
	rm -rf docs/auto_gallery docs/reference/generated
	rm -rf .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(INSTALLED): pyproject.toml
	@command -v $(PYTHON) >/dev/null || { \
	    echo "$(PYTHON) was not found. Install Python 3.11 or newer, or name it:" \
	         "make PYTHON=python3.11 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; v = sys.version_info; v >= (3, 11) or sys.exit( \
	    "nonsmooth needs Python 3.11 or newer, and $(PYTHON) is %d.%d. " \
	    "Name a newer one: make PYTHON=python3.11 ..." % (v[0], v[1]))'
	@echo "Setting up $(VENV) (some minutes, once)"
	@# Where venv cannot bring its own pip, the pip of the interpreter outside installs it.
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null && $(PYTHON) -m venv $(VENV) || { \
	    $(PYTHON) -m venv --without-pip $(VENV) && \
	    $(PYTHON) -m pip --python $(BIN)/python install --quiet pip; }
	$(PIP_INSTALL) '.[dev]'
	@touch $@

$(INSTALLED_BENCHMARK): $(INSTALLED)
	$(PIP_INSTALL) '.[benchmark]'
	@touch $@

$(INSTALLED_DOCS): $(INSTALLED)
	$(PIP_INSTALL) '.[docs]'
	@touch $@
