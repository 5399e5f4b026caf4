"""Speed and memory of the models on one core, in batches of 10x10 frames.

``python -m bench.speed.speed`` measures each model in a process of its own with one thread, writes
``bench/results/speed.json`` and the table in docs/measured.md.
"""

import json
import os
import platform
import re
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bench.publish import ROOT

FRAMES, REPEATS = 10_000, 5
EXAMPLES = {"tfra": "fast.toml", "learned": "learned_fast.toml", "resultant": "learned_resultant.toml"}
NAMES = {
    "tfra float": "TFRA, float",
    "tfra standard": "bit-accurate, `standard`",
    "tfra wide": "bit-accurate, `wide`",
    "tfra c": "in C, `standard`",
    "tfra csim": "C simulation of HLS, with its files",
    "learned float": "learned, float",
    "learned standard": "bit-accurate",
    "learned c": "in C",
    "learned csim": "C simulation of HLS, with its files",
    "resultant c": "in C, without forces at the taxels",
}
"""What is measured, and its name in the table."""


def simulation(design: Any, codes: Any, folder: Path) -> Callable[[Any], Any]:
    """A function that runs an HLS core's testbench, built as its README says, over ``codes``, which are in files."""
    from tfra.codegen.hls.files import data, files

    frames = codes.reshape(len(codes), -1)
    texts = files(design) | {
        "tb_data/tb_input_features.dat": data(frames),
        "tb_data/tb_output_predictions.dat": data(design.model(frames).words),
    }
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (build,) = re.findall(r"^    (g\+\+ .*)$", texts["README.md"], re.M)
    package = find_spec("hls4ml")
    assert package, "pip install hls4ml==1.3.0"
    build = build.replace("hls4ml/hls4ml", str(Path(package.origin or "").parent)).replace("-O1", "-O3")
    subprocess.run(build.split(), cwd=folder, check=True)
    return lambda _: subprocess.run(["./csim"], cwd=folder, check=True, capture_output=True)


def run(engine: str) -> dict[str, Any]:
    """Frames per second (median and best of ``REPEATS``) and peak memory of one engine, if it is in this process."""
    from dataclasses import replace

    from tfra.codegen.config.read import load
    from tfra.model.choices import FORMATS
    from tfra.model.cover.scenes import contact_codes
    from tfra.runtime.scratch import scratch, temporary
    from tfra.sim.compiled import Compiled

    estimator, kind = engine.split()
    design = load(ROOT / "examples" / EXAMPLES[estimator]).design
    if kind == "wide":
        design = replace(design, formats=FORMATS["wide"])
    codes = contact_codes(design, FRAMES, seed=1)
    os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
    data: Any = codes * design.adc.lsb if kind == "float" else codes
    rates = []
    with scratch(temporary()) as folder:
        models: dict[str, Callable[[], Callable[[Any], Any]]] = {
            "float": lambda: design.float_model,
            "c": lambda: Compiled(design).words,
            "csim": lambda: simulation(design, codes, folder),
            "fixed": lambda: design.model,
            "wide": lambda: design.model,
        }
        model = models[kind]()
        model(data[:100])
        for _ in range(REPEATS):
            start = time.perf_counter()
            model(data)
            rates.append(FRAMES / (time.perf_counter() - start))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"median": statistics.median(rates), "best": max(rates), "peak_mib": None if kind == "csim" else peak}


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
    for name, row in rows.items():
        peak = f"{row['peak_mib']:.0f} MiB" if row["peak_mib"] else "—"
        lines.append(f"| {NAMES[name]} | {row['median']:,.0f} | {row['best']:,.0f} | {peak} |")
    record = {"frames": FRAMES, "repeats": REPEATS, "machine": platform.processor() or platform.machine(), "rows": rows}
    publish("speed", record, "\n".join(lines))


if __name__ == "__main__":
    main()
