"""What parallelism buys: cycles of 10x10 cores, from the timing that tests compare with the gateware.

``python -m bench.cores`` writes ``bench/results/cores.json`` and the table in README.md.
"""

from __future__ import annotations

from bench.publish import publish
from tfra.codegen.images import depth
from tfra.hdl.timing import Timing
from tfra.model.design import Architecture, Design
from tfra.model.sensor import SensorArray

CORES = ((1, 1), (4, 1), (12, 1), (12, 4), (16, 4), (32, 4), (52, 4), (100, 4))
"""MAC lanes, and words of a vector a cycle behind them."""


def main() -> None:
    """Compute and publish."""
    lines = [
        "| MAC lanes | words a cycle | first word after | last word after | interval | coefficients a lane |",
        "|---:|---:|---:|---:|---:|---:|",
    ]
    record = []
    for mac, width in CORES:
        design = Design(SensorArray(10, 10, 4e-3, 2e-3, 3e-3), architecture=Architecture(mac, width))
        timing, words = Timing(design), depth(design)
        cycles = timing.latency, timing.frame_latency, timing.initiation_interval
        lines.append(f"| {mac} | {width} | " + " | ".join(f"{c:,}" for c in cycles) + f" | {words:,} |")
        record.append({"mac_lanes": mac, "vector_words": width, "cycles": cycles, "depth": words})
    publish("cores", {"sensor": "10x10", "multiplications": timing.multiplications, "rows": record}, "\n".join(lines))


if __name__ == "__main__":
    main()
