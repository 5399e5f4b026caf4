"""Fit the prices of serial cores to syntheses for the iCE40UP5K: ``python -m bench.parts.serial`` writes them.

A lookup table of the estimate is a logic cell here, as nextpnr packs them: there are a quarter more of them than lookup
tables, since flip-flops behind block memories, multipliers and carries take cells of their own.
"""

import re
import sys
import tempfile
from pathlib import Path
from typing import Any

from bench.parts.estimates import asked, conclude, measured
from bench.publish import ROOT
from tfra.families import find
from tfra.model.choices import FORMATS, SERIAL, Adc, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.flow import NETLIST, synthesise
from tfra.synth.run import netlist
from tfra.synth.tools import run

DATA = ROOT / "synth" / "estimate_serial.json"
TARGET = find("ice40up5k")


def design(rows: int, columns: int, **others: Any) -> Design:
    """A serial core on a grid of 4 mm x 2 mm."""
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    return TfraDesign(sensor, name=f"s{rows}x{columns}", architecture=SERIAL, target="ice40", **others)


FITTED = (
    design(4, 4, search=Search(20)),
    design(2, 2, adc=Adc(10)),
    design(6, 8, formats=FORMATS["wide"]),
    design(8, 8, adc=Adc(12), formats=Formats("custom", 14, 14, 5, 3)),
    design(3, 5, adc=Adc(8), formats=Formats("custom", 10, 10, 2, 2)),
)
UNSEEN = (
    design(10, 10),
    design(5, 7, search=Search(16, 2.5)),
    design(9, 7, adc=Adc(16), formats=Formats("custom", 16, 20, 10, 4)),
    design(4, 7, adc=Adc(10), formats=Formats("custom", 12, 16, 6, 3)),
    design(8, 12, adc=Adc(12)),
    design(7, 7, search=Search(200), formats=Formats("custom", 20, 20, 11, 6)),
)


def measure(subject: Design) -> dict[str, Any]:
    """Features and resources of one design."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = dict(synthesise(netlist(subject, TARGET), subject.name, TARGET, folder).resources)
        tool = TARGET.family.place_and_route
        assert tool
        run(tool.program, [*TARGET.device, "--json", NETLIST, "--pack-only"], folder, "pack.log")
        (cells,) = re.findall(rf"{''.join(tool.bels['LUT'])}: +(\d+)/", (folder / "pack.log").read_text())
    return {"name": subject.name, "features": asked(subject, TARGET.family), "measured": found | {"LUT": int(cells)}}


def main(arguments: list[str]) -> None:
    """Measure, fit, write and print; with ``--refit`` the designs are counted anew, but not synthesised."""
    designs = {"fitted": FITTED, "unseen": UNSEEN}
    conclude(measured(arguments, DATA, designs, TARGET.family, measure), DATA, ("LUT", "FF", "BRAM"))


if __name__ == "__main__":
    main(sys.argv[1:])
