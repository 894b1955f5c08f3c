# make demo    set up, run the circle test on the built-in robot, print the tables, write report.html; diagnose the example logs
# make test    set up, run the tests            make test-all   the slow ones too
# make check   format, lint, types, import rules
# make bench   speed and memory of simulation and environments, against the bare engine, onto docs/performance_history.jsonl;
#               ends in an error if a ratio lost 10 % of what recent runs there had; BENCH="--json FILE" passes options;
#               then a short exam of the diagnosis
# make fuzz    100,000 damaged files for every reader, an hour or two; goes on where it was interrupted; FUZZ="--seed 2"
# make exam    both whole exams, some hours on 2 cores, onto their page docs/bench_diagnosis.md; goes on where it was
#               interrupted; SEED=12 is another exam
# make thesis  chapters 4 to 6 of the thesis simulated, every claim judged, onto reproduction.html; THESIS="--only chapter-4"
# make claims  every number of README and docs made again, hours; says which no longer hold, and goes on where it was
#               interrupted; CLAIMS=--short compares with stored results alone, in seconds
# make engine  does MuJoCo move robots and environments as the record of the last release says, to the bit? MUJOCO=4.1.0 asks
#              that release, in an environment that is thrown away; ENGINE="--json FILE" passes options
# PYTHON=python3.12 chooses the interpreter of a new environment; CONSTRAINTS= installs the newest versions.

PYTHON ?= python3
CONSTRAINTS ?= -c constraints.txt
BIN := .venv/bin
# processes of the tests, which take up to 3 GB each; JOBS=0 runs them in one, as a debugger needs it
JOBS ?= 2
SEED ?= 7
PYTEST := OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(JOBS) --dist worksteal
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check $(CONSTRAINTS)

.PHONY: demo test test-all check bench fuzz exam thesis claims engine format clean

demo: .venv/.demo
	$(BIN)/ffgym demo

test: .venv/.dev
	$(PYTEST)

test-all: .venv/.dev
	$(PYTEST) -m ""

check: .venv/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: .venv/.dev
	$(BIN)/python -m scripts.bench --history docs/performance_history.jsonl $(BENCH)
	$(BIN)/python -m scripts.exam --cases 1 --jobs 2

fuzz: .venv/.dev
	$(BIN)/python -m scripts.fuzz --inputs 100000 --out out/fuzz $(FUZZ)

exam: .venv/.dev
	$(BIN)/python -m scripts.exam --seed $(SEED) --jobs 2 --out out/exam
	$(BIN)/python -m scripts.exam.page --seed $(SEED) --out out/exam --commit $$(git describe --always --dirty)
	$(BIN)/python -m scripts.exam --exam independent --seed $(SEED) --jobs 2 --out out/exam
	$(BIN)/python -m scripts.exam.page --exam independent --seed $(SEED) --out out/exam --commit $$(git describe --always --dirty)

thesis: .venv/.dev
	$(BIN)/python -m scripts.thesis $(THESIS)

claims: .venv/.dev
	$(BIN)/python -m scripts.claims $(CLAIMS)

ifdef MUJOCO
engine:
	@set -e; at=$$(mktemp -d); trap 'rm -rf "$$at"' EXIT; $(PYTHON) -m venv "$$at"; grep -v '^mujoco' constraints.txt > "$$at/constraints.txt"; \
	"$$at/bin/python" -m pip install --quiet --disable-pip-version-check -c "$$at/constraints.txt" -e '.[cli]' pin 'mujoco==$(MUJOCO)'; \
	"$$at/bin/python" -m scripts.engine $(ENGINE)
else
engine: .venv/.dev
	$(BIN)/python -m scripts.engine $(ENGINE)
endif

format: .venv/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "ffgym needs Python 3.11 or newer; PYTHON=/path/to/python3.12 make ..."; exit 1; }
	$(PYTHON) -m venv .venv

.venv/.demo: .venv/bin/python pyproject.toml constraints.txt
	$(PIP) -e '.[cli,report,paths]'
	@touch $@

.venv/.dev: .venv/bin/python pyproject.toml constraints.txt
	$(PIP) -e '.[dev]'
	@touch $@ .venv/.demo

clean:
	rm -rf .venv build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
