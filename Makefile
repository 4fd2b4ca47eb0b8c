# Everything a newcomer runs. `make demo` needs Python and a network to the package index;
# `make test` also needs gfortran and Python's headers, and Chromium for the page, and installs them
# when missing.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out

.PHONY: demo test quick lint format proof proof-small acceptance docs physics api tutorial screenshots golden
.PHONY: dist wheel sanitize clean
.PHONY: nulls real same mutants-diagnosis calibrate efficiency mounts watch-nights watch-replays watch-kills watch-week
.PHONY: fuzz torture faults machines lock audit
.PHONY: bench bench-record growth FORCE
.PHONY: parity-long parity-matrix parity-slalib mutants coverage parity-report

$(BIN)/pyport: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "pyport needs Python 3.11 or newer; say which with make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

demo: $(BIN)/pyport
	$(BIN)/pyport demo --out $(OUT)

$(BIN)/tox: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet 'tox>=4.11'
	@touch $@

test: $(BIN)/tox
	@sh .ci/install gfortran
	@PYTHON=$(PYTHON) sh .ci/install headers
	@sh .ci/install chromium || [ "$$PYPORT_BROWSER" != required ]
	$(BIN)/tox run

$(VENV)/test: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	@touch $@

# The quick tests alone, while you work, on two cores.
quick: $(VENV)/test
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q -n 2 tests --ignore tests/reliability \
	  -m 'not slow and not browser and not oracle'

lint: $(BIN)/tox
	$(BIN)/tox run -e lint

format: $(BIN)/tox
	$(BIN)/python -m pip install --quiet 'ruff>=0.8'
	$(BIN)/ruff check --fix pyport tests legacy_fortran
	$(BIN)/ruff format pyport tests legacy_fortran

# The page on the effects, from the catalogue.
physics: $(BIN)/pyport
	$(BIN)/pyport dev effects --markdown -o docs/physics.md

# The documentation as a site that needs no network: every warning is an error, every link is followed.
$(VENV)/docs: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	@touch $@

docs: $(VENV)/docs
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet \
	  --doctree-dir $(OUT)/doctrees docs $(OUT)/docs
	$(BIN)/python docs/check_site.py $(OUT)/docs
	@echo "read $(OUT)/docs/index.html"

# What is published: a wheel and a source archive.
dist: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet 'build>=1.2'
	$(BIN)/python -m build --outdir dist

# The compiled kernel, and the program beside it; needs a C compiler. Installed, it is used.
KERNEL := pyport/pointing/kernel_src

wheel: dist
	$(BIN)/python -m build --wheel --outdir dist $(KERNEL)

# The kernel's tests with every load, store, sum and cast watched; ROUNDS calls drawn at random.
ROUNDS ?= 20000
SANITIZED := $(OUT)/sanitized

sanitize: $(BIN)/pyport
	@sh .ci/install gfortran
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	rm -rf $(SANITIZED)
	$(BIN)/python -m pip install --quiet --no-deps --target $(SANITIZED) $(KERNEL) \
	  -Csetup-args=-Db_sanitize=address,undefined -Csetup-args=-Db_lundef=false \
	  -Csetup-args=-Dc_args=-fsanitize=float-cast-overflow
	LD_PRELOAD=$$($${CC:-cc} -print-file-name=libasan.so) ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 \
	  UBSAN_OPTIONS=halt_on_error=1 PYTHONPATH=$(SANITIZED) PYPORT_KERNEL=required \
	  PYPORT_KERNEL_ROUNDS=$(ROUNDS) $(BIN)/python -m pytest -q -p no:cacheprovider tests/pointing tests/steering/test_lookup.py

# The reference of every public name, from the docstrings.
api: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet 'pdoc>=15'
	$(BIN)/pdoc --docformat numpy --output-directory $(OUT)/api pyport

# The tutorial with its answers, to be read in a browser.
tutorial: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet nbconvert ipykernel
	$(BIN)/jupyter nbconvert --execute --to html --output-dir $(OUT) docs/tutorial.ipynb

# The README's pictures of the page.
screenshots: $(BIN)/pyport
	@sh .ci/install chromium
	$(BIN)/python -m pip install --quiet playwright
	$(BIN)/python docs/pictures/screenshots.py

# What the long checks of parity need beside the program.
$(VENV)/oracle: $(VENV)/test
	@sh .ci/install gfortran
	@PYTHON=$(PYTHON) sh .ci/install headers
	@touch $@

CONFIG ?= legacy_fortran/parity.toml
ANSWERS := $(dir $(CONFIG))answers

golden: $(VENV)/oracle
	$(BIN)/pyport parity golden --config $(CONFIG)
	$(BIN)/python -m pyport.steering.golden

# Each long check leaves its figures among the stored answers; parity-report shows them.
parity-long: $(VENV)/oracle
	$(BIN)/pyport parity --config $(CONFIG) --points 10000000 --json > $(VENV)/run.json
	mv $(VENV)/run.json $(ANSWERS)/run.json

parity-matrix: $(VENV)/oracle
	@sh .ci/install-flang
	$(BIN)/pyport parity matrix --config $(CONFIG)

mutants: $(VENV)/oracle
	$(BIN)/pyport parity mutants --config $(CONFIG)

coverage: $(VENV)/oracle
	$(BIN)/pyport parity coverage --config $(CONFIG)

parity-report: $(BIN)/pyport
	$(BIN)/pyport parity --stored --report docs/parity.md

# SLALIB, fetched from the package index, held against pyerfa; then its tests.
parity-slalib: $(VENV)/oracle
	$(BIN)/python tests/parity/slalib/fetch.py $(VENV)/slalib
	$(BIN)/pyport parity --config $(VENV)/slalib/parity.toml --points 20000
	PYPORT_SLALIB=$(VENV)/slalib $(BIN)/python -m pytest -q tests/parity/test_slalib.py

# Hidden truths, solved blind, opened, scored; killed and called again, they go on. The small set is a
# rehearsal that is kept nowhere; of the other one each call goes as far as the next commit.
proof-small: $(BIN)/pyport
	$(BIN)/pyport dev trials prove $(OUT)/proof-small --set small --jobs 2

NAME ?= proof
proof: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet --editable '.[challenge]'
	$(BIN)/pyport dev prove --set full --name $(NAME) --jobs 2 --out $(OUT)/sets

# Small wrong changes of the noise, the diagnosis, the fit and the effects: what the tests notice.
mutants-diagnosis: $(VENV)/test
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/mutants/run.py

# Ten fixed inputs diagnosed by this program and by an earlier one: code that moves changes no report.
BASE ?= HEAD

same: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/reliability/same.py $(BASE)

# False alarms against thresholds, and coverage, in every kind of noise; goes on where it was stopped.
calibrate: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/pyport dev calibrate --jobs 2 --out $(OUT)/calibrate \
	  --into docs/method.md

# Detections and right names over those of an observer who knows the cause's form and the noise.
efficiency: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/pyport dev efficiency --jobs 2 --out $(OUT)/efficiency

# What is promised of a diagnosis, measured anew: real recordings and drawn cases.
DATA ?= ../shared/data
acceptance: $(BIN)/pyport
	$(BIN)/pyport dev acceptance --jobs 2 --data $(DATA)

# Recordings with nothing hidden in every kind of noise: claims, and how often sigmas hold.
CASES ?= 100
nulls: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/pyport dev nulls --cases $(CASES) --jobs 2 --out $(OUT)/nulls

# Causes by name, and silence, on drawn sessions of German, fork and X-Y mounts: docs/mounts.md.
mounts: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/pyport dev mounts --cases $(CASES) --jobs 2 --out $(OUT)/mounts

# The watch on simulated nights: false alarms, delays beside the best possible; on public recordings.
watch-nights: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/pyport dev nights --nulls 1000 --steps 1000 --out $(OUT)/nights

watch-replays: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/pyport dev replays --data $(DATA)

# Kills of a watch that follows a log; a week of readings every ten seconds.
watch-kills: $(BIN)/tox
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	OPENBLAS_NUM_THREADS=1 PYPORT_WATCH_KILLS=$(KILLS) $(BIN)/python -m pytest -q tests/watch/test_run.py -k killed

watch-week: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/watch/week.py

# Public recordings of other telescopes, and those shipped, beside what was published of them.
real: $(BIN)/pyport
	OPENBLAS_NUM_THREADS=1 $(BIN)/pyport dev real --data $(DATA) --jobs 2 --out $(OUT)/real \
	  --markdown docs/real.md

# Every reader against spoilt files for SECONDS; every writer against KILLS kills, LOAD other processes
# beside it; every command with FAULTS faults in it.
SECONDS ?= 600
KILLS ?= 200
LOAD ?= 0
FAULTS ?= 25

$(VENV)/fuzz: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet --editable '.[fuzz]'
	@touch $@

fuzz: $(VENV)/fuzz
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/reliability/fuzz.py --seconds $(SECONDS) --out $(OUT)/fuzz

torture: $(BIN)/pyport
	$(BIN)/python tests/reliability/torture.py --kills $(KILLS) --load $(LOAD) \
	  $(if $(SEED),--seed $(SEED))

faults: $(BIN)/pyport
	$(BIN)/python tests/reliability/faults.py --faults $(FAULTS) $(if $(SEED),--seed $(SEED))

# Reports of ten inputs as other processors and core counts give them; PYTHONS names other Pythons.
machines: $(BIN)/pyport
	$(BIN)/python tests/reliability/machines.py $(addprefix --python ,$(PYTHONS))

# The versions and hashes that continuous integration installs, for every Python and system;
# what is known against what is installed.
lock: $(BIN)/pyport
	$(BIN)/python -m pip install --quiet 'uv>=0.5'
	$(BIN)/uv pip compile --quiet --upgrade --universal --python-version 3.11 --generate-hashes \
	  --no-annotate --custom-compile-command 'make lock' --extra test --extra lint \
	  --output-file .ci/requirements.lock pyproject.toml

audit: $(BIN)/tox
	$(BIN)/tox run -e audit

# Ours beside what one would take instead, in one run. ROWS is the size of the data set that is read.
ROWS ?= 1e7
BENCH := $(VENV)/bench.json

$(VENV)/bench: $(BIN)/pyport
	@sh .ci/install gfortran
	$(BIN)/python -m pip install --quiet --editable '.[test,bench]'
	$(BIN)/python -m pip install --quiet --force-reinstall --no-deps $(KERNEL)
	@touch $@

$(BENCH): $(VENV)/bench FORCE
	OPENBLAS_NUM_THREADS=1 PYPORT_BENCH_ROWS=$(ROWS) $(BIN)/pytest tests/benchmarks -q \
	  --benchmark-enable --benchmark-only --benchmark-json=$@ --benchmark-columns=min,rounds

# Prints the table beside the last recorded run; bench-record also records it, writes docs/performance.md.
bench: $(BENCH)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/benchmarks/performance.py show $(BENCH)

bench-record: $(BENCH)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/benchmarks/performance.py record $(BENCH)

# Data sets of up to LARGEST rows are written to the temporary folder: 5 GB for 1e8.
LARGEST ?= 1e8
growth: $(VENV)/bench
	$(BIN)/python tests/benchmarks/growth.py all docs/growth.json $(LARGEST)
	$(BIN)/python tests/benchmarks/performance.py page

FORCE:

clean:
	rm -rf $(VENV) .tox build dist $(OUT)
