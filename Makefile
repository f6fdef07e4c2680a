# make run | test | check | fuzz | bench | install
PYTHON ?= $(firstword $(shell command -v python3.11 python3 python 2>/dev/null))
HOST ?= 127.0.0.1
PORT ?= 8080
BIN := .venv/bin
PEER := $(shell sed -n 's/^peers = \["\(.*\)"\].*/\1/p' pyproject.toml)
# A Pi's camera library, picamera2, comes with the system; the environment has to see it.
HAS_CAMERA := -c 'from importlib.util import find_spec; exit(find_spec("picamera2") is None)'
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet
# The locks have the files for these machines; elsewhere only the versions are fixed.
HAS_HASHES := -c 'import platform as p, sys; exit(not ((3, 11) <= sys.version_info < (3, 14) and \
  p.libc_ver()[0] == "glibc" and p.machine() in ("x86_64", "aarch64")))'
PIP_AUDIT := pip-audit==2.10.1
MINUTES ?= 60
# From kept bytecode a program starts in a third of the time; tests start hundreds.
export PYTHONDONTWRITEBYTECODE :=
APT_INSTALL := DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends
NPM_CI := npm ci --prefix .venv --ignore-scripts --no-audit --no-fund --loglevel=error

# Install a lock, then the project itself, whose files have no hash.
define install
if $(BIN)/python $(HAS_HASHES); then \
  $(PIP) --require-hashes --requirement $(1) && \
  $(PIP) --no-deps --no-build-isolation --editable .; \
else \
  echo "Installing without hashes: the locks are for Linux with Python 3.11 to 3.13." >&2; \
  $(PIP) --constraint constraints.txt --editable '$(2)'; fi
endef

.DEFAULT_GOAL := help
.PHONY: help run install test check format fuzz lock audit bench
.PHONY: browser peers node-peers dds-peer official-library

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "make %-17s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

run: install ## set up, then serve the dashboard (PORT=9000 make run for another port)
	@exec $(BIN)/brickpose run --host $(HOST) --port $(PORT)

install: .venv/installed ## set up the virtual environment

# Tests that assert when a program, a page or a port does something have the machine to themselves;
# the others wait a lot. What is compiled first: code read from the cache gives other last digits.
test: .venv/installed-dev browser node-peers dds-peer ## run every test
	$(BIN)/python -m app.tools.warm_up
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -m "not real_time" \
	  -n 3 --dist loadfile --no-loadscope-reorder
	$(BIN)/python -m pytest -m real_time $$(grep -l mark.real_time tests/test_*.py)

check: .venv/installed-dev ## lint, names, types, and who may import whom
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python tests/lint_names.py
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

format: .venv/installed-dev ## tidy the source
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

fuzz: .venv/installed-dev ## feed every reader damaged files for an hour (MINUTES=5 make fuzz)
	PYTHONPATH=.:tests OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/fuzz/campaign.py --minutes $(MINUTES)

lock: .venv/installed-dev ## write the hashes of all that is installed, after a change of versions
	$(BIN)/python tests/lock_requirements.py

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
	@$(call install,requirements.lock,.)
	@# The system's simplejpeg, which picamera2 imports, is made for the system's older numpy.
	@! $(BIN)/python $(HAS_CAMERA) || $(PIP) --ignore-installed --no-deps simplejpeg==1.9.0
	@echo "Compiling (once) ..."
	@$(BIN)/python -m app.tools.warm_up
	@touch $@

.venv/installed-dev: .venv/installed requirements-dev.lock
	@echo "Setting up the tools for tests and checks (once) ..."
	@$(call install,requirements-dev.lock,.[dev])
	@# What pytest makes of each test's source is kept, too; its workers would all make it at once.
	@$(BIN)/python -m pytest --collect-only -qq >/dev/null
	@touch $@
