# Every target sets up what it needs in .venv; the second run finds it there.
# Another interpreter: make PYTHON=python3.12 test

PYTHON ?= python3
JOBS ?= auto
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed-dev
INSTALLED_BENCHMARK := $(VENV)/.installed-benchmark
INSTALLED_DOCS := $(VENV)/.installed-docs
VENV_ROSS := build/ross
ENGINE_SOURCES := build_engine.py $(wildcard src/nonsmooth/engine/native/*)
ENGINE := src/nonsmooth/engine/_declarations.py
SANITIZED := build/sanitized/engine.so
PIP_INSTALL_TOOLS = $(BIN)/python -m pip --disable-pip-version-check install --quiet
# Modules compile when they are first imported: most never are, and to compile all takes half of the time.
PIP_INSTALL_MODULES = $(PIP_INSTALL_TOOLS) --no-compile
PIP_INSTALL = $(PIP_INSTALL_MODULES) --editable

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo chapter test check style slow ross bench docs engine sanitize wheels clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-7s %s\n", $$1, $$2 }' Makefile

demo: $(ENGINE) ## draw the chapter's demonstration into demo-output
	$(BIN)/nonsmooth chapter demo --out demo-output

chapter: $(ENGINE) ## draw and judge the whole chapter into chapter-output/report.html
	$(BIN)/nonsmooth chapter run --all --out chapter-output

# the processes of the tests share the processors already
test slow: export OPENBLAS_NUM_THREADS ?= 1

test: $(ENGINE) ## run the tests and the examples in docstrings
	$(BIN)/python -m pytest --numprocesses=$(JOBS)

check: style ## style, format, types, imports, spelling, house tests
	$(BIN)/python -m pytest tests/house

style: $(ENGINE) ## the same without the house tests, which are among those of make test
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell

slow: $(ENGINE) ## run the long checks
	$(BIN)/python -m pytest --numprocesses=$(JOBS) -m slow

ross: $(ENGINE) $(VENV_ROSS)/.installed ## compare shafts with ROSS, which has an environment of its own
	$(VENV_ROSS)/bin/python -m pytest tests/structures/test_ross.py -m slow -p no:cacheprovider

bench: $(INSTALLED_BENCHMARK) $(ENGINE) ## run the benchmarks
	$(BIN)/python benchmarks

docs: $(INSTALLED_DOCS) $(ENGINE) ## build the documentation site into docs-output; a warning or a broken link is an error
	$(BIN)/sphinx-build -b html -E -d docs-output/doctrees -j auto -n -W --keep-going docs \
	    docs-output/html
	$(BIN)/python docs/links.py docs-output/html

engine: $(ENGINE) ## compile the engine where its sources have changed

sanitize: $(ENGINE) $(SANITIZED) ## run the tests of the engine under sanitizers of addresses and undefined behaviour
	NONSMOOTH_ENGINE=$(CURDIR)/$(SANITIZED) ASAN_OPTIONS=detect_leaks=0 \
	LD_PRELOAD="$$(c++ -print-file-name=libasan.so) $$(c++ -print-file-name=libubsan.so)" \
	    $(BIN)/python -m pytest tests/engine tests/contract -p no:cacheprovider

wheels: $(INSTALLED) ## build wheels for Linux, macOS and Windows into dist
	$(PIP_INSTALL_TOOLS) build ziglang
	@for platform in linux-x86_64 linux-aarch64 macos-x86_64 macos-arm64 windows-x86_64; do \
	    NONSMOOTH_PLATFORM=$$platform $(BIN)/python -m build --wheel --outdir dist . || exit 1; \
	done

clean: ## remove all that these targets made, .venv included
	rm -f $(ENGINE) src/nonsmooth/engine/_nonsmooth_*
	rm -rf $(VENV) build dist demo-output chapter-output benchmark-output docs-output
	rm -rf docs/auto_gallery docs/reference/generated
	rm -rf .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(INSTALLED): pyproject.toml studies/chapter/pyproject.toml
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
	@# The engine compiles while packages come. Without a compiler, the last step brings one.
	@$(PYTHON) build_engine.py --libraries 2>/dev/null & \
	$(BIN)/python -c 'import tomllib; told = tomllib.load(open("pyproject.toml", "rb"))["project"]; \
	    print(*told["dependencies"], *told["optional-dependencies"]["dev"], sep="\n")' \
	    > $(VENV)/requirements.txt && \
	$(PIP_INSTALL_MODULES) --requirement $(VENV)/requirements.txt; \
	installed=$$?; wait; exit $$installed
	$(PIP_INSTALL) '.[dev]' --editable ./studies/chapter
	@touch $@

$(VENV_ROSS)/.installed: pyproject.toml | $(INSTALLED)
	@echo "Setting up $(VENV_ROSS) (some minutes, once)"
	$(PYTHON) -m venv --without-pip $(VENV_ROSS)
	$(BIN)/python -m pip --python $(VENV_ROSS)/bin/python --disable-pip-version-check install \
	    --quiet --editable '.[ross]' pytest hypothesis
	@touch $@

$(ENGINE): $(ENGINE_SOURCES) | $(INSTALLED)
	$(BIN)/python build_engine.py

$(SANITIZED): $(ENGINE_SOURCES) | $(INSTALLED)
	$(BIN)/python build_engine.py --sanitized $@

$(INSTALLED_BENCHMARK): $(INSTALLED)
	$(PIP_INSTALL) '.[benchmark]'
	@touch $@

$(INSTALLED_DOCS): $(INSTALLED)
	$(PIP_INSTALL) '.[docs]'
	@touch $@
