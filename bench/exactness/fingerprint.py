"""Fingerprints of some designs, one line each: netlist, stated cycles, program and words of the model.

``python -m bench.exactness.fingerprint`` prints them.  A change of the source that changes no line has changed none of
these cores.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from bench.exactness.designs import untrained
from tfra.codegen.verilog.emit import Top, to_rtlil
from tfra.hdl.cores import as_serial, microarchitecture
from tfra.hdl.serial.trace import trace
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Search
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

_SQUARE = SensorArray(4, 4, 4e-3, 2e-3, 3e-3)
_ODD = SensorArray(5, 7, 3e-3, 3e-3, 2e-3)
_TINY = SensorArray(2, 3, 2e-3, 3e-3, 2e-3)

DESIGNS = (
    TfraDesign(_SQUARE, search=Search(20), architecture=Architecture(4), target="ecp5"),
    TfraDesign(_ODD, search=Search(16, 2.5), architecture=Architecture(48), target="ice40"),
    TfraDesign(_TINY, adc=Adc(contact_threshold=0), search=Search(5), architecture=Architecture(4), images="load"),
    TfraDesign(_ODD, adc=Adc(16), search=Search(9), formats=FORMATS["wide"], architecture=Architecture(8, 1)),
    TfraDesign(_SQUARE, adc=Adc(18), search=Search(33), architecture=Architecture(12, 2)),
    TfraDesign(_TINY, search=Search(5), architecture=SERIAL),
    TfraDesign(_ODD, adc=Adc(8), search=Search(16, 2.5), architecture=SERIAL, target="ecp5"),
    TfraDesign(_SQUARE, search=Search(33), formats=FORMATS["wide"], architecture=SERIAL, target="ice40"),
    untrained(3, 5, (3, 2), adc=Adc(16), architecture=Architecture(8, 2), target="ecp5"),
    untrained(4, 4, (2, 5), formats=FORMATS["wide"], architecture=Architecture(4), taxel_forces=False, images="load"),
    untrained(2, 3, (2, 3), adc=Adc(12, contact_threshold=0), architecture=SERIAL, target="ice40"),
    untrained(5, 4, (7, 2), formats=FORMATS["wide"], architecture=SERIAL, taxel_forces=False),
)

ARRAYS = ((2, 3), (3, 5), (4, 4), (6, 5))
"""Rows and columns of arrays whose cycles alone are compared, for several numbers of lanes."""


def fingerprint(design: Design) -> str:
    """A hash for each thing that may change."""
    return " ".join(f"{key}={_hash(value)}" for key, value in _facts(design))


def _facts(design: Design) -> Iterator[tuple[str, Any]]:
    core = microarchitecture(design)
    core.check()
    yield "cycles", (core.latency, core.frame_latency, core.initiation_interval, core.settled, core.enough)
    yield "lanes", (core.lanes, core.lane_choices, [path.name for path in core.cell_models], core.load_order)
    yield "probes", core.probes
    for name in ("coefficients", "loaded"):
        yield name, _bytes(getattr(core, name))
    yield "netlist", to_rtlil(Top(design), "core")
    codes = np.concatenate([contact_codes(design, 100, 1), directed_codes(design), wild_codes(design, 100, 2)])
    result = design.model(codes)
    yield "words", _bytes(result.words)
    yield "values", [(name, _bytes(value)) for stages in result.parts for name, value in stages.items()]
    yield "design", (design.widths, design.layout, design.multiplications, design.nonzero_products, design.frame_words)
    if design.architecture == SERIAL:
        yield "program", [str(step) for step in trace(as_serial(replace(design, target="portable")), codes[:2])]


def _bytes(values: Any) -> bytes:
    return np.ascontiguousarray(values, dtype=np.int64).tobytes() if values is not None else b""


def _hash(value: Any) -> str:
    return hashlib.blake2b(repr(value).encode(), digest_size=8).hexdigest()


def timed() -> Iterator[Design]:
    """Small arrays of both estimators with all kinds of lanes."""
    for (rows, columns), words in product(ARRAYS, (1, 2, 4)):
        most = 4 * -(-rows // 2) * -(-columns // 2)
        for lanes in sorted({4, most // 8 * 4 or 4, most}):
            architecture = Architecture(lanes, words)
            yield TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), search=Search(12), architecture=architecture)
            yield untrained(rows, columns, (columns, words), architecture=architecture, taxel_forces=rows % 2 == 0)


def cycles(design: Design) -> tuple[int, int, int]:
    """What is stated of a design."""
    core = microarchitecture(design)
    return core.latency, core.frame_latency, core.initiation_interval


def main() -> None:
    """A line for the cycles of many designs, and one for each of ``DESIGNS``."""
    print(_hash([cycles(design) for design in timed()]), flush=True)
    for design in DESIGNS:
        print(fingerprint(design), flush=True)


if __name__ == "__main__":
    main()
