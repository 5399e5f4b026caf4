"""Instructions and memory of cores in C on a Cortex-M7, in QEMU.

``python -m bench.speed.cortex`` generates presets in C, follows their README, writes ``bench/results/cortex.json``
and the table in docs/howto/cortex_m.md.  It needs what ``make cross`` installs.
"""

import re
import subprocess
from pathlib import Path
from typing import Any

from bench.publish import ROOT, publish
from tfra.codegen.c.files import files
from tfra.codegen.c.memory import ram_bytes
from tfra.codegen.config.read import load
from tfra.runtime.scratch import scratch, temporary

EXAMPLES = {
    "fast": "TFRA, forces at the taxels",
    "learned_fast": "learned, forces at the taxels",
    "learned_resultant": "learned, resultant alone",
}
LEVELS = ("-Os", "-O2", "-O3")


def measure(example: str, level: str, folder: Path) -> dict[str, Any]:
    """Instructions of a frame, bytes of stack, RAM and flash."""
    design = load(ROOT / "examples" / f"{example}.toml").design
    texts = files(design)
    for name, text in texts.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    *_, build, emulate = re.findall(r"^    ((?:arm|qemu)-.*)$", texts["README.md"], re.M)
    subprocess.run(build.replace("-O2", level).split(), cwd=folder, check=True)
    said = subprocess.run(emulate.split(), cwd=folder, check=True, capture_output=True, text=True).stdout
    least, most, stack = map(int, re.findall(r"(\d+) to (\d+) instructions, (\d+) bytes of stack", said)[0])
    compiled = ["arm-none-eabi-gcc", "-std=c99", level, "-mcpu=cortex-m7", "-mthumb", "-c"]
    subprocess.run([*compiled, f"{design.name}.c", f"{design.name}_tables.c"], cwd=folder, check=True)
    sizes = ["arm-none-eabi-size", f"{design.name}.o", f"{design.name}_tables.o"]
    rows = subprocess.run(sizes, cwd=folder, check=True, capture_output=True, text=True).stdout.splitlines()[1:]
    code, tables = (int(row.split()[0]) for row in rows)
    memory = {"stack": stack, "ram": ram_bytes(design), "code": code, "tables": tables}
    return {"products": design.multiplications, "least": least, "most": most, **memory}


def main() -> None:
    """Measure every preset with every level and publish."""
    rows = {}
    for example in EXAMPLES:
        for level in LEVELS:
            with scratch(temporary()) as folder:
                rows[f"{example} {level}"] = measure(example, level, folder)
    version = subprocess.run(
        ["arm-none-eabi-gcc", "-dumpfullversion"], check=True, capture_output=True, text=True
    ).stdout
    lines = [
        "| estimator, 10×10 taxels | level | instructions of a frame | a product | stack | RAM | code | tables |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for key, row in rows.items():
        example, level = key.split()
        sizes = " | ".join(f"{row[name]:,} B" for name in ("stack", "ram", "code", "tables"))
        count = f"{row['least']:,} to {row['most']:,} | {row['most'] / row['products']:.1f}"
        lines.append(f"| {EXAMPLES[example]} | `{level}` | {count} | {sizes} |")
    publish("cortex", {"gcc": version.strip(), "rows": rows}, "\n".join(lines), "docs/howto/cortex_m.md")


if __name__ == "__main__":
    main()
