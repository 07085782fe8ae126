# Every target sets up .venv by itself when it is missing; nothing but Python 3.11, 3.12 or 3.13 with its venv module is needed.
# Another Python than the default: `make clean`, then `make test PYTHON=python3.13`.
SHELL := /bin/bash
PYTHON ?= $(shell command -v python3.11 || command -v python3.12 || command -v python3.13 || command -v python3)
BIN := .venv/bin
STAMP := .venv/.installed
TESTS ?= tests
JOBS ?= 2
# Tasks to sweep; all when empty.
TASKS ?=
export OMP_NUM_THREADS ?= 1

.PHONY: help setup demo lint check format test test-browser docs sweep baselines bench lock clean

help:
	@echo "make demo    a Panda takes the lid off a saucepan: an episode and a video in out/demo"
	@echo "make check   format, lint, types and the quick tests: before every commit"
	@echo "make test    all tests but the long ones: before a merge"
	@echo "make test-browser  the task builder in a browser, which it installs where it may"
	@echo "make docs    the documentation site, in out/docs; a warning is an error"
	@echo "make lint    format, lint and types only"
	@echo "make format  format, and fix what the linter can"
	@echo "make sweep   100 demonstrations of each task and the long tests; writes docs/results and the table in README.md"
	@echo "make baselines  records, trains and plays the baselines; writes docs/results/baselines and docs/baselines.md"
	@echo "make bench   how fast; writes benchmarks/results"
	@echo "make lock    newest versions that pyproject.toml allows, into constraints.txt"

setup: $(STAMP)

# Installs again when pyproject.toml or the tested versions change.
$(STAMP): pyproject.toml constraints.txt
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,bench]'
	@touch $(STAMP)

demo: $(STAMP)
	$(BIN)/rlbench-pin demo take_lid_off_saucepan --episodes 1 --out out/demo --video

lint: $(STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/mypy --explicit-package-bases $$(find rlbench_pin/compat/packages -name '*.py')

check: lint
	$(BIN)/pytest -m "not slow and not simulation and not browser" -n $(JOBS) --dist worksteal $(TESTS)

format: $(STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

test: $(STAMP)
	$(BIN)/pytest -m "not slow and not browser" -n $(JOBS) --dist worksteal $(TESTS)

# Debian's Chromium, where this runs as root with apt-get; without a browser the tests are skipped and say why. Pictures of the steps: out/browser.
test-browser: $(STAMP)
	@if ! command -v chromedriver > /dev/null && command -v apt-get > /dev/null && [ "$$(id -u)" = 0 ]; then \
		apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium chromium-driver > /dev/null \
		|| echo "Chromium could not be installed; the tests are skipped."; fi
	$(BIN)/pytest -m "browser and not slow" -rs tests/builder/browser \
		|| { echo "What failed is tried once more: a browser without a graphics card may be late."; \
		$(BIN)/pytest -m "browser and not slow" --last-failed tests/builder/browser; }

# Conditions of tasks are read from worlds, one process for each core; then Sphinx.
docs: $(STAMP)
	$(BIN)/python scripts/build_docs.py --jobs $(JOBS)

# One Python installs one of the two distributions of PyBullet; their lines are kept, and renewed by hand.
lock:
	rm -rf .venv-lock && $(PYTHON) -m venv .venv-lock
	.venv-lock/bin/python -m pip install --quiet --disable-pip-version-check -e '.[dev,bench]'
	.venv-lock/bin/python -m pip freeze --exclude-editable | grep -v '^pybullet' > .venv-lock/constraints.txt
	grep '^pybullet' constraints.txt >> .venv-lock/constraints.txt
	mv .venv-lock/constraints.txt constraints.txt
	rm -rf .venv-lock

# 100 demonstrations of each task in all its variations, 100 on seeds that nobody has looked at, key frames of 20, friction only of 20, and the whole contract. A stopped sweep goes on: finished trials are kept in out/sweep, and the table
# keeps tasks on which nothing changed. It is written also when a task fails; the exit code says so afterwards. A sweep of some TASKS adds them to the table.
TABLE := docs/results/demo_success.json
sweep: $(STAMP)
	mkdir -p out/sweep && touch out/sweep/.begun
	status=0; $(BIN)/rlbench-pin check $(TASKS) --episodes 100 --variations 100 --unseen 100 --key-frames 20 --friction-only 20 --contract-seeds 30 --workers $(JOBS) --out out/sweep --no-images --update $(TABLE) || status=$$?; \
	test $(TABLE) -nt out/sweep/.begun && $(BIN)/python scripts/update_readme.py && { test -n "$(strip $(TASKS))" || $(BIN)/pytest -m slow -n $(JOBS) $(TESTS); } && exit $$status

# Records, trains and plays the baselines, hours on two cores; a stopped run goes on. Writes docs/results/baselines and the tables of docs/baselines.md.
baselines: $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[learn,rl,classical]"
	$(BIN)/python scripts/run_baselines.py --jobs $(JOBS)

bench: $(STAMP)
	$(BIN)/python benchmarks/run_all.py --out benchmarks/results

clean:
	rm -rf .venv out build dist .pytest_cache .ruff_cache .mypy_cache
