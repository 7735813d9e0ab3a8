# Sets everything up by itself in a virtual environment. Needs make and Python 3.11.
#
#   make demo     read a sentence, infer where the car is, search for it; pictures go to out/
#   make web      say a sentence and watch the search in the browser; it prints the address
#   make test     run the tests
#   make test-web run the tests of the pages in Chromium, which it installs
#   make docs     build the documentation as a site into build/site; open its index.html
#   make tutorials run the notebooks and write their pages; make gallery draws every plot anew
#   make graphics install what the simulator makes pictures with, where apt-get can
#   make check    ruff, codespell, and mypy --strict on the built wheel
#   make pyright  check the examples with pyright against the built wheel's types; needs node
#   make mutants  change the code in 300 places, one at a time, and see whether the tests notice
#   make coverage run the tests and print which share of each room's statements they ran
#   make venv     only make the virtual environment
#   make lock     write requirements.lock anew, from what is installed
#   make clean    remove what the above have written, except the virtual environment
#
# Variables, given as NAME=value after make:
#   PYTHON             the interpreter the virtual environment is made with
#   VENV               where the virtual environment lies
#   TORCH              which PyTorch to install; it is installed first, so that nothing else chooses
#   TORCH_PIP_OPTIONS  further options for the pip call that installs PyTorch. The default build may
#                      bring several GB of CUDA libraries; who wants the CPU wheels gives here the
#                      --index-url option that PyTorch's own page on installing names for them
#   LOCK               a file of versions with hashes, as requirements.lock, of which all but PyTorch
#                      is installed; continuous integration does so. The newest that
#                      pyproject.toml allows when empty
#   MUTANTS_OPTIONS    options for make mutants, such as "--seed 1 --minutes 30" or "--again"
#   WEB_OPTIONS        options for make web, such as "--open --map my_city.geojson"
#   PICTURES           folder into which make test-web puts the pictures of docs/workbench.md
#   PYTEST_OPTIONS     options for pytest; it uses all processors unless told otherwise

PYTHON ?= python3.11
VENV ?= .venv
TORCH ?= torch==2.13.0
TORCH_PIP_OPTIONS ?=
LOCK ?=
MUTANTS_OPTIONS ?=
WEB_OPTIONS ?=
AXE ?= axe-core@4.14.1
PICTURES ?=
PYTEST_OPTIONS ?= -n auto --dist loadgroup

BIN := $(abspath $(VENV))/bin
STAMP := $(VENV)/.installed
MUTANTS_STAMP := $(VENV)/.installed-mutants
WHEEL := build/check

.PHONY: demo web test test-web graphics docs tutorials gallery check pyright mutants coverage venv lock clean
.DELETE_ON_ERROR:

demo: $(STAMP)
	$(BIN)/sloop demo --out out

web: $(STAMP)
	$(BIN)/sloop serve $(WEB_OPTIONS)

# As many processes as processors: a second thread in each would only wait for its turn.
test: export OMP_NUM_THREADS ?= 1
test: $(STAMP)
	$(BIN)/python -m pytest $(PYTEST_OPTIONS)

# Chromium is the system's; where apt-get cannot install it, the tests are skipped and say so. The
# accessibility rules come from npm into out/, where the tests look for them.
test-web: export OMP_NUM_THREADS ?= 1
test-web: $(STAMP)
	command -v chromium >/dev/null || ! command -v apt-get >/dev/null || \
	  timeout 300 apt-get install -y --no-install-recommends chromium || \
	  (timeout 100 apt-get update && timeout 300 apt-get install -y --no-install-recommends chromium) || true
	test -e out/axe/node_modules/axe-core || \
	  npm install --silent --prefix out/axe --no-save --ignore-scripts $(AXE) || true
	$(BIN)/python -m pytest -n 2 --dist loadfile --reruns 1 tests/web $(if $(PICTURES),--pictures $(PICTURES))

docs: export NO_MKDOCS_2_WARNING ?= 1
docs: $(STAMP)
	$(BIN)/python -m mkdocs build --quiet --clean
	@echo "build/site/index.html"

tutorials: $(STAMP)
	$(BIN)/python docs/site_tools/tutorials.py

gallery: $(STAMP)
	$(BIN)/python examples/gallery.py --out docs

# EGL of Mesa draws without a screen. Where nothing can be installed, tests that need pictures skip.
GRAPHICS := libegl1 libgl1-mesa-dri libosmesa6
graphics:
	ldconfig -p 2>/dev/null | grep -qE 'libEGL.so.1|libOSMesa' || ! command -v apt-get >/dev/null || \
	  timeout 150 apt-get install -y --no-install-recommends $(GRAPHICS) || \
	  (timeout 100 apt-get update && (timeout 150 apt-get install -y --no-install-recommends $(GRAPHICS) || \
	  timeout 150 apt-get install -y --no-install-recommends libegl1 libgl1-mesa-dri)) || true

# mypy cannot see through the editable install, and a whole wheel is what users get.
check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell
	rm -rf build
	$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir $(WHEEL)/wheel .
	$(BIN)/python -m pip install --quiet --no-deps --target $(WHEEL)/site $(WHEEL)/wheel/*.whl
	cd $(WHEEL)/site && $(BIN)/mypy --config-file $(CURDIR)/pyproject.toml \
	  --cache-dir $(CURDIR)/.mypy_cache --strict -p sloop_ppl

# The package on the index fetches pyright itself from npm.
pyright: check
	$(BIN)/python -m pip install --quiet pyright
	$(BIN)/python -m pyright --pythonpath $(BIN)/python

# Verdicts are kept in out/mutants; a run that was stopped goes on where it was.
mutants: export OMP_NUM_THREADS ?= 1
mutants: $(MUTANTS_STAMP)
	$(BIN)/python tests/tools/mutants.py $(MUTANTS_OPTIONS)

coverage: export OMP_NUM_THREADS ?= 1
coverage: $(MUTANTS_STAMP)
	mkdir -p out
	$(BIN)/python -m pytest $(PYTEST_OPTIONS) --cov --cov-report=json:out/coverage.json
	$(BIN)/python tests/tools/coverage_by_room.py out/coverage.json

$(MUTANTS_STAMP): $(STAMP)
	$(BIN)/python -m pip install --editable ".[dev,mutants]"
	touch $@

venv: $(STAMP)

lock: $(STAMP)
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/python tests/tools/lock_environment.py

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --upgrade pip
	$(BIN)/python -m pip install $(TORCH_PIP_OPTIONS) "$(TORCH)"
	$(if $(LOCK),$(BIN)/python -m pip install --no-deps --require-hashes --requirement $(LOCK))
	$(BIN)/python -m pip install --editable ".[dev]"
	-$(BIN)/sloop warmup
	touch $@

clean:
	rm -rf build dist out *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find sloop_ppl models inference eval tests -name __pycache__ -type d -prune -exec rm -rf {} +
