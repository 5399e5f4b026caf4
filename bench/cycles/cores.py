"""Cycles of 10x10 cores by parallelism, from the timing that tests compare with the gateware.

``python -m bench.cycles.cores`` writes ``bench/results/cores.json`` and the table in docs/measured.md.
"""

from typing import Any

from bench.publish import publish
from tfra.hdl.parallel.matvec.images import depth
from tfra.hdl.parallel.tfra.core import TfraParallel
from tfra.model.choices import Architecture
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

CORES = ((4, 1), (8, 1), (12, 1), (12, 4), (16, 4), (32, 4), (52, 4), (100, 4))
"""MAC lanes, and words of a vector a cycle after them."""


def design(mac_lanes: int, vector_words: int = 4) -> Design:
    """The 10x10 core with that parallelism."""
    return TfraDesign(SensorArray(10, 10, 4e-3, 2e-3, 3e-3), architecture=Architecture(mac_lanes, vector_words))


def main() -> None:
    """Compute and publish."""
    record, lines = rows()
    products = design(4).multiplications
    publish("cores", {"sensor": "10x10", "multiplications": products, "rows": record}, "\n".join(lines))


def rows() -> tuple[list[dict[str, Any]], list[str]]:
    """The cores as a record, and as a table in Markdown."""
    lines = [
        "| MAC lanes | words a cycle | first word after | last word after | interval | coefficients a lane |",
        "|---:|---:|---:|---:|---:|---:|",
    ]
    record = []
    for mac, width in CORES:
        core = design(mac, width)
        timing, words = TfraParallel(core), depth(core)
        cycles = timing.latency, timing.frame_latency, timing.initiation_interval
        lines.append(f"| {mac} | {width} | " + " | ".join(f"{c:,}" for c in cycles) + f" | {words:,} |")
        record.append({"mac_lanes": mac, "vector_words": width, "cycles": list(cycles), "depth": words})
    return record, lines


if __name__ == "__main__":
    main()
