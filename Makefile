# One command per habit. Each target stands alone: on a fresh machine with Python 3.11 or newer and
# make, it builds .venv from requirements.lock first; afterwards it starts at once.
# `make lock` alone needs uv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
JOBS ?= auto

.DEFAULT_GOAL := help
.PHONY: help setup demo check format lint types imports test test-whole nightly bench bench-gap bias study docs \
  withheld another-camera lock

help:  ## list these commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

setup: $(READY)  ## make the virtual environment .venv from pinned versions

demo: $(READY)  ## render, capture, measure, compare with the truth: camtruth-out/demo/report.html
	$(BIN)/camtruth demo --overwrite

check: format lint types imports test test-whole  ## format, lint, strict types, import order, tests

test: $(READY)  ## the tests, but for those that take a minute each
	$(BIN)/python -m pytest -n $(JOBS) -m "not whole"

test-whole: $(READY)  ## these: whole diagnoses of whole captures, above all
	$(BIN)/python -m pytest -n $(JOBS) -m whole

nightly: $(READY)  ## all of them with 5,000 damaged inputs and kills at more moments
	CAMTRUTH_NIGHTLY=1 CAMTRUTH_CASES=5000 $(BIN)/python -m pytest -n $(JOBS)

bench: $(READY)  ## speeds as ratios in one run
	$(BIN)/python -m benchmarks

# About a minute a case on a core: what is done is kept, and the next run goes on from there.
# Other options by hand: python -m analysis.gap_bench run --help
MINUTES ?= 600
SEED ?= 1
bench-gap: $(READY)  ## the diagnosis, measured: cases of SEED for MINUTES, then the table
	$(BIN)/python -m analysis.gap_bench run --seed $(SEED) --minutes $(MINUTES)
	$(BIN)/python -m analysis.gap_bench publish --seed $(SEED)

# Hours on a few cores: what is done is kept, and the next run goes on from there.
bias: $(READY)  ## the long runs behind docs/bias.md: docs/results/ (go on where they stopped)
	$(BIN)/python -m analysis.bias cells --seeds 12
	$(BIN)/python -m analysis.bias debias --seeds 12
	$(BIN)/python -m analysis.bias failures --seeds 4
	for camera in i400 icx098; do for raw in "" --raw; do \
	  $(BIN)/python -m analysis.bias coverage --camera $$camera $$raw --seeds 48 --method irie \
	    --method emva1288 --method photon_transfer --method corrected || exit; done; done
	for camera in i400 icx098; do \
	  $(BIN)/python -m analysis.bias coverage --camera $$camera --seeds 2000 || exit; done

study: $(READY)  ## the study gradient-quantization: its page, and docs/results/ (goes on)
	$(BIN)/camtruth study gradient-quantization --seeds 4 --resume --out camtruth-out/study
	cp camtruth-out/study/gradient-quantization.parquet docs/results/

# Two CPU-minutes a case: what is done is kept, and the next run goes on from there.
SET := camtruth-out/blind/withheld
CASES ?= null=14 own=14 pair=4 left-out=6 decoy=4 put-back=6 others=10 strange=10

withheld: $(READY)  ## examine the diagnosis with effects it cannot know: docs/withheld.md (goes on)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[withheld]'
	test -d $(SET) || $(BIN)/camtruth blind make --set $(notdir $(SET)) --out $(SET) --seed $(SEED) \
	  $(addprefix --cases ,$(CASES)) --resume
	test -d $(SET).histogram || $(BIN)/camtruth blind solve $(SET) --solver histogram --resume
	test -d $(SET).refit-free || $(BIN)/camtruth blind solve $(SET) --solver refit-free --resume
	test -d $(SET).answers || { $(BIN)/camtruth blind solve $(SET) --resume && \
	  git rev-parse --short HEAD > $(SET).answered-by; }
	test -d $(SET).score || $(BIN)/camtruth blind score $(SET) \
	  --beside histogram=$(SET).histogram --beside refit-free=$(SET).refit-free
	$(BIN)/python -m docs.withheld_page $(SET).score $$(cat $(SET).answered-by)

PIXELS ?= rgb8
# An hour on two cores: what is done is kept, and the next run goes on from there.
another-camera: $(READY)  ## the diagnosis on a NumPy camera, fault by fault: docs/another-camera.md
	$(BIN)/python -m docs.another_camera_page --pixels $(PIXELS)

DEMO := camtruth-out/demo

docs: $(READY)  ## write the pages and figures that docs/make.py lists (a demo first, if there is none)
	test -f $(DEMO)/capture/capture.toml || $(BIN)/camtruth demo --overwrite
	$(BIN)/python docs/make.py

format: $(READY)
	$(BIN)/ruff format --check .

lint: $(READY)
	$(BIN)/ruff check .

types: $(READY)
	$(BIN)/mypy

imports: $(READY)
	$(BIN)/lint-imports

# The packages are installed only when their list, or the way this one is built, has changed.
$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "make: $(PYTHON) is $$($(PYTHON) --version 2>&1); camtruth needs Python 3.11 or newer;" \
	    "install one and name it, as in: make PYTHON=python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "make: $(PYTHON) cannot make virtual environments;" \
	    "expected its venv module; install it (Debian: apt install python3-venv)" >&2; exit 1; }
	@echo "Making $(VENV) from requirements.lock: once, for a minute or two."
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --requirement requirements.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation \
	  --editable .
	@touch $@

lock:  ## make requirements.lock anew from pyproject.toml; needs uv
	@command -v uv >/dev/null || { echo "make: no uv; expected it on the path, as it resolves" \
	  "requirements.lock; install it (pip install uv)" >&2; exit 1; }
	uv pip compile pyproject.toml --group build --extra dev --extra exchange --universal --python-version 3.11 \
	  --fork-strategy fewest --no-header --no-annotate --quiet --output-file requirements.lock.new
	{ head -2 requirements.lock; grep -v "python_full_version >= '3.15'" requirements.lock.new \
	  | sed "s/ ; python_full_version < '3.15'$$//; s/python_full_version < '3.15' and //"; } \
	  > requirements.lock.merged
	mv requirements.lock.merged requirements.lock
	rm requirements.lock.new
