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

from bench.publish import ROOT

FRAMES, REPEATS = 10_000, 5
EXAMPLES = {"tfra": "fast.toml", "learned": "learned_fast.toml", "resultant": "learned_resultant.toml"}
NAMES = {
    "tfra float": "TFRA, float",
    "tfra standard": "bit-accurate, `standard`",
    "tfra wide": "bit-accurate, `wide`",
    "tfra c": "in C, `standard`",
    "learned float": "learned, float",
    "learned standard": "bit-accurate",
    "learned c": "in C",
    "resultant c": "in C, without forces at the taxels",
}
"""What is measured, and its name in the table."""


def run(engine: str) -> dict[str, Any]:
    """Frames per second (median and best of ``REPEATS``) and peak memory of one engine, in this process."""
    from dataclasses import replace

    from tfra.codegen.config.read import load
    from tfra.model.choices import FORMATS
    from tfra.model.cover.scenes import contact_codes
    from tfra.sim.compiled import Compiled

    estimator, kind = engine.split()
    design = load(ROOT / "examples" / EXAMPLES[estimator]).design
    if kind == "wide":
        design = replace(design, formats=FORMATS["wide"])
    codes = contact_codes(design, FRAMES, seed=1)
    os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
    models: dict[str, Callable[[Any], Any]] = {"float": design.float_model, "c": Compiled(design).words}
    model = models.get(kind, design.model)
    data: Any = codes * design.adc.lsb if kind == "float" else codes
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
    rows = {}
    for engine in NAMES:
        command = [sys.executable, "-m", "bench.speed.speed", engine]
        done = subprocess.run(command, env=os.environ | threads, capture_output=True, text=True, check=True)
        rows[engine] = json.loads(done.stdout)
    lines = ["| model | frames/s, median | frames/s, best | peak memory |", "|---|---:|---:|---:|"]
    lines += [
        f"| {NAMES[e]} | {r['median']:,.0f} | {r['best']:,.0f} | {r['peak_mib']:.0f} MiB |" for e, r in rows.items()
    ]
    record = {"frames": FRAMES, "repeats": REPEATS, "machine": platform.processor() or platform.machine(), "rows": rows}
    publish("speed", record, "\n".join(lines))


if __name__ == "__main__":
    main()
