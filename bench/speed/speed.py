"""Speed and memory of the models on one core, in batches of 10x10 frames.

``python -m bench.speed.speed`` measures each model in a process of its own with one thread, writes
``bench/results/speed.json`` and the table in docs/measured.md.
"""

import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

FRAMES, REPEATS = 10_000, 5


def run(engine: str) -> dict[str, Any]:
    """Frames per second (median and best of ``REPEATS``) and peak memory of one engine, in this process."""
    from tfra.model.choices import FORMATS
    from tfra.model.cover.scenes import contact_codes
    from tfra.model.fixed.tfra.design import TfraDesign
    from tfra.model.fixed.tfra.pipeline import FixedTfra
    from tfra.model.sensor import SensorArray
    from tfra.model.tfra import Tfra

    formats = FORMATS["wide" if engine == "wide" else "standard"]
    design = TfraDesign(SensorArray(10, 10, 4e-3, 2e-3, 3e-3), formats=formats)
    codes = contact_codes(design, FRAMES, seed=1)
    frames = codes * design.adc.lsb
    model: Callable[[Any], Any] = Tfra(design.sensor) if engine == "float" else FixedTfra(design)
    data: Any = frames if engine == "float" else codes
    model(data[:100])
    rates = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        model(data)
        rates.append(FRAMES / (time.perf_counter() - start))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"median": statistics.median(rates), "best": max(rates), "peak_mib": peak}


def main() -> None:
    """Measure every engine in a process of its own and publish."""
    if len(sys.argv) > 1:
        print(json.dumps(run(sys.argv[1])))
        return
    from bench.publish import publish

    threads = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    names = {"float": "float", "standard": "bit-accurate, `standard`", "wide": "bit-accurate, `wide`"}
    rows = {}
    for engine in names:
        command = [sys.executable, "-m", "bench.speed.speed", engine]
        done = subprocess.run(command, env=os.environ | threads, capture_output=True, text=True, check=True)
        rows[engine] = json.loads(done.stdout)
    lines = ["| model | frames/s, median | frames/s, best | peak memory |", "|---|---:|---:|---:|"]
    lines += [
        f"| {names[e]} | {r['median']:,.0f} | {r['best']:,.0f} | {r['peak_mib']:.0f} MiB |" for e, r in rows.items()
    ]
    record = {"frames": FRAMES, "repeats": REPEATS, "machine": platform.processor() or platform.machine(), "rows": rows}
    publish("speed", record, "\n".join(lines))


if __name__ == "__main__":
    main()
