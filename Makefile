# make run | test | check | fuzz | bench | install
PYTHON ?= $(firstword $(shell command -v python3.11 python3 python 2>/dev/null))
HOST ?= 127.0.0.1
PORT ?= 8080
BIN := .venv/bin
PEER := $(shell sed -n 's/^peers = \["\(.*\)"\].*/\1/p' pyproject.toml)
# A Pi's camera library, picamera2, comes with the system; the environment has to see it.
HAS_CAMERA := -c 'from importlib.util import find_spec; exit(find_spec("picamera2") is None)'
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet
PIP_AUDIT := pip-audit==2.10.1
MINUTES ?= 60
# From kept bytecode a program starts in a third of the time; tests start hundreds.
export PYTHONDONTWRITEBYTECODE :=
APT_INSTALL := DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends
NPM_CI := npm ci --prefix .venv --ignore-scripts --no-audit --no-fund --loglevel=error

# The environment is made anew for another Python that is asked for, and where its own is gone.
DRY := $(findstring n,$(filter-out -%,$(firstword $(MAKEFLAGS))))
ifneq ($(and $(wildcard .venv),$(filter-out help,$(MAKECMDGOALS)),$(if $(DRY),,really)),)
VERSION := -c 'import sys; v = sys.version_info; print("%d.%d" % v[:2] if v >= (3, 11) else "")'
HAVE := $(shell $(BIN)/python $(VERSION) 2>/dev/null)
WANT := $(if $(filter file,$(origin PYTHON)),$(HAVE),$(shell $(PYTHON) $(VERSION) 2>/dev/null))
ifneq ($(or $(WANT),$(filter file,$(origin PYTHON))),)
ifneq ($(HAVE),$(or $(WANT),none))
$(info Making .venv anew$(if $(WANT), for Python $(WANT)): it was of $(or $(HAVE),a Python that is gone).)
$(shell rm -rf .venv)
endif
else
$(error $(PYTHON) is no Python 3.11 or newer)
endif
endif

# Install a lock, then the project itself, whose files have no hash.
define install
$(PIP) --require-hashes --requirement $(1) && \
$(PIP) --no-deps --no-build-isolation --editable .
endef

# Tests beside each other, on two cores: most of the quick ones wait now and then, so three at once.
# A slow one has processes of its own (a program, a browser) and would only be kept waiting.
TEST_BESIDE = OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --dist loadfile --no-loadscope-reorder
TEST_AGAIN = $(BIN)/python -m pytest --last-failed --last-failed-no-failures none

.DEFAULT_GOAL := help
.PHONY: help run install test test-rest test-all check format fuzz lock platforms audit bench
.PHONY: browser peers node-peers dds-peer official-library

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "make %-17s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

run: install ## set up, then serve the dashboard (PORT=9000 make run for another port)
	@exec $(BIN)/brickpose run --host $(HOST) --port $(PORT)

install: .venv/installed ## set up the virtual environment

# Code is compiled first: code read from the cache gives other last digits.
test: .venv/installed-dev browser node-peers dds-peer ## run the tests that a change is tried with, in some minutes
	$(BIN)/python -m app.tools.warm_up
	$(TEST_BESIDE) -n 3 -m "not real_time and not slow"

# Tests that assert when a program, a page or a port does something have the machine to themselves;
# the others wait a lot. What failed beside others is tried once more with nothing beside it, and
# pytest names it: a busy machine may keep a browser waiting for a minute. A fault fails twice.
test-rest: .venv/installed-dev browser node-peers dds-peer ## run those that make test leaves out, for three quarters of an hour
	$(BIN)/python -m app.tools.warm_up
	$(TEST_BESIDE) -n 3 -m "slow and not real_time" || { [ $$? = 1 ] && $(TEST_AGAIN) -m "slow and not real_time"; }
	$(BIN)/python -m pytest -m real_time $$(grep -rl --include='test_*.py' mark.real_time tests) || \
	{ [ $$? = 1 ] && $(TEST_AGAIN) -m real_time; }

test-all: test test-rest ## run every test

check: .venv/installed-dev ## lint, names, types, who may import whom, public workflow, container
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python tests/project/lint_names.py
	$(BIN)/python tests/project/lint_modules.py
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/zizmor --offline --quiet .github/workflows
	$(BIN)/hadolint Dockerfile

format: .venv/installed-dev ## tidy the source
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

fuzz: .venv/installed-dev ## feed every reader damaged files for an hour (MINUTES=5 make fuzz)
	PYTHONPATH=.:tests:tests/helpers OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/fuzz/campaign.py --minutes $(MINUTES)

lock: .venv/installed-dev ## write the hashes of all that is installed, after a change of versions
	$(BIN)/python tests/project/lock_requirements.py

platforms: .venv/installed-dev ## ask a resolver what is installed on which system, with which physics
	$(BIN)/python tests/project/resolved_platforms.py

audit: .venv/bin/python ## ask a public database for known weaknesses of what is installed
	@[ -x .venv/audit/bin/pip-audit ] || { $(PYTHON) -m venv .venv/audit && \
	  .venv/audit/bin/python -m pip --disable-pip-version-check install --quiet '$(PIP_AUDIT)'; } || { \
	  echo "No audit: pip-audit cannot be installed; it needs the network." >&2; exit 1; }
	@.venv/audit/bin/pip-audit --strict --disable-pip --require-hashes --progress-spinner off \
	  --requirement requirements-dev.lock >.venv/audit/told 2>&1; status=$$?; cat .venv/audit/told; \
	if grep -qE 'could not be audited|ConnectionError|Max retries' .venv/audit/told; then \
	  echo "No audit: the database of weaknesses does not answer from here." >&2; fi; exit $$status

bench: .venv/installed-dev peers ## measure, beside peers
	$(BIN)/brickpose bench

official-library: .venv/installed ## Raspberry Pi's own library on the emulated Build HAT, 50 starts
	$(BIN)/brickpose bench official_library

peers: .venv/installed-dev
	@[ -e .venv/peers/nav2_$(subst ==,-,$(PEER)).so ] || { \
	  echo "Building peers to measure against (once) ..." && \
	  $(BIN)/python -m pip --disable-pip-version-check download --quiet --no-deps --no-binary amcl \
	    --dest .venv/peers '$(PEER)' && \
	  $(BIN)/python -m benchmarks.nav2_amcl .venv/peers/$(subst ==,-,$(PEER)).tar.gz; } || \
	echo "Measuring without nav2_amcl: it needs a C++ compiler and PyPI." >&2

node-peers: .venv/bin/python ## npm's clients and readers, which the tests run against ours
	@cmp -s tests/node/package-lock.json .venv/package-lock.json && [ -d .venv/node_modules ] || { \
	  command -v npm >/dev/null && echo "Setting up npm packages for tests (once) ..." && \
	  cp tests/node/package.json tests/node/package-lock.json .venv/ && $(NPM_CI) >/dev/null; } || { \
	  rm -rf .venv/node_modules .venv/package-lock.json; \
	  echo "Tests with clients from npm are skipped: they need node 20, npm and its registry." >&2; }

dds-peer: ## another vendor's DDS, which the tests of ROS 2 run against ours
	@[ -e /usr/include/fastdds/dds/domain/DomainParticipant.hpp ] || \
	{ [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get update -qq && \
	  $(APT_INSTALL) libfastrtps-dev >/dev/null; } || \
	echo "Tests with a foreign DDS are skipped: sudo apt-get install libfastrtps-dev" >&2

browser:
	@command -v chromium-headless-shell chromium chromium-browser google-chrome >/dev/null || \
	{ [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get update -qq && \
	  { $(APT_INSTALL) chromium-headless-shell || $(APT_INSTALL) chromium; } >/dev/null; } || \
	{ echo "The browser tests need Chromium: sudo apt-get install chromium-headless-shell" >&2; exit 1; }

.venv/bin/python:
	@[ -n "$(PYTHON)" ] || { echo "Python 3.11 or newer is missing: https://www.python.org/downloads/" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	{ echo "BrickPose needs Python 3.11 or newer; $(PYTHON) is $$($(PYTHON) --version 2>&1)." >&2; exit 1; }
	@$(PYTHON) -m venv $$($(PYTHON) $(HAS_CAMERA) && echo --system-site-packages) .venv || { echo "Python's venv module is missing: sudo apt-get install python3-venv" >&2; exit 1; }

.venv/installed: pyproject.toml constraints.txt requirements.lock | .venv/bin/python
	@echo "Setting up .venv (once) ..."
	@$(call install,requirements.lock)
	@# The system's simplejpeg, which picamera2 imports, is made for the system's older numpy.
	@! $(BIN)/python $(HAS_CAMERA) || $(PIP) --ignore-installed --no-deps simplejpeg==1.9.0
	@echo "Compiling (once) ..."
	@$(BIN)/python -m app.tools.warm_up
	@touch $@

.venv/installed-dev: .venv/installed requirements-dev.lock
	@echo "Setting up the tools for tests and checks (once) ..."
	@$(call install,requirements-dev.lock)
	@# What pytest makes of each test's source is kept, too; its workers would all make it at once.
	@$(BIN)/python -m pytest --collect-only -qq >/dev/null
	@touch $@
