"""Runs the default studies: their results, their duration, and the proof that workers and kills change no byte.

python -m bench.exactness.bits           # an hour on two idle cores; fills docs/how_many_bits.md
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from bench.publish import ROOT, insert, store
from tfra.codegen.config.read import load
from tfra.report.numbers import number
from tfra.study.errors.cascade import Step, View
from tfra.study.report.labels import QUANTITIES, STEPS
from tfra.study.report.summary import HEADLINE, summary
from tfra.study.search.evaluate import CHANGE
from tfra.study.studyfile import load_study

PAGE = "docs/how_many_bits.md"
PLACE = ROOT / "build" / "studies"
STUDIES = ("hertz", "rectangle", "skin")
TUTORIAL = "skin"
_TICK = 0.5


@dataclass(frozen=True)
class Took:
    """Seconds of a run, and the most memory of all its processes together, in MB."""

    seconds: float
    megabytes: float


def study(file: str, out: str, workers: int, kill: Sequence[float] = (), work: str | None = None) -> Took:
    """Run the study in ``file``; it is killed and begun again after each time of ``kill``."""
    start, most = time.perf_counter(), 0.0
    command = [sys.executable, "-m", "tfra.cli", "study", file, "--out", str(PLACE / out), "--workers", str(workers)]
    command += ["--work", str(PLACE / f"{work or out}.work")]
    for patience in (*kill, None):
        with subprocess.Popen(command, cwd=ROOT, start_new_session=True) as run, watched(run.pid) as seen:
            try:
                code = run.wait(patience)
            except subprocess.TimeoutExpired:
                run.kill()
                continue
        most = max(most, *seen)
        if code:
            raise SystemExit(code)
    return Took(time.perf_counter() - start, most)


def example(name: str) -> str:
    """The file of a default study."""
    return f"examples/study_{name}.toml"


def placed(name: str) -> None:
    """Place and route the designs of a finished study, with the report in ``placed``."""
    text = (ROOT / example(name)).read_text().replace('config = "', f'config = "{ROOT}/examples/')
    (PLACE / "placed.toml").write_text(f"{text}\n[place]\n")
    study(str(PLACE / "placed.toml"), "placed", 2, work=name)


@contextmanager
def watched(session: int) -> Iterator[list[float]]:
    """Memory of all processes of ``session``, in MB, every half second."""
    seen, ended = [0.0], threading.Event()

    def look() -> None:
        while not ended.wait(_TICK):
            seen.append(sum(_resident(entry) for entry in Path("/proc").glob("[0-9]*") if _session(entry) == session))

    thread = threading.Thread(target=look)
    thread.start()
    try:
        yield seen
    finally:
        ended.set()
        thread.join()


def _session(process: Path) -> int:
    try:
        return os.getsid(int(process.name))
    except OSError:
        return -1


def _resident(process: Path) -> float:
    """A process' private memory, and its share of the memory that it shares."""
    try:
        lines = (process / "smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return sum(int(line.split()[1]) / 1024 for line in lines if line.startswith("Pss:"))


def content(out: str) -> dict[str, str]:
    """Hashes of a report's files, except the times."""
    folder = PLACE / out
    files = (file for file in folder.rglob("*") if file.name not in ("times.html", "tfra-manifest.json"))
    return {str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest() for f in files if f.is_file()}


def table(out: str, name: str) -> pl.DataFrame:
    """A table of a report."""
    return pl.read_parquet(PLACE / out / "tables" / f"{name}.parquet")


def cascade(out: str) -> str:
    """What each step adds, and the total, on held-out frames."""
    found = table(out, "errors").filter(part="held_out")
    lines = ["| step | " + " | ".join(f"error of {_kind(name)}" for name in HEADLINE) + " |"]
    lines.append("|---|" + "---:|" * len(HEADLINE))
    rows = [(STEPS[step], step, View.OWN) for step in Step] + [("all together", Step.ARITHMETIC, View.TOTAL)]
    for label, step, view in rows:
        cells = []
        for quantity in HEADLINE:
            row = found.row(by_predicate=_is(quantity=quantity, step=step, view=view), named=True)
            cells.append(f"{number(row['median'])} / {number(row['p95'])}")
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _kind(quantity: str) -> str:
    kind = QUANTITIES[quantity]
    return f"{kind.label}, {kind.unit}: median / 95th percentile".replace("|", "\\|")


def _is(**wanted: Any) -> pl.Expr:
    return pl.all_horizontal(*(pl.col(name) == str(value) for name, value in wanted.items()))


def uniform(out: str) -> str:
    """Growth of the total error with uniform products, by their bits."""
    rows = table(out, "uniform_trials").filter(state="complete").sort("bits").iter_rows(named=True)
    head = ["| bits | growth of the total, worst quantity, % | coefficients, kbit | DSP |", "|---:|---:|---:|---:|"]
    lines = [
        f"| {row['bits']} | {row[CHANGE]:.2f} | {row['coefficient_kbit']:.1f} | {row['DSP']:.0f} |" for row in rows
    ]
    return "\n".join([*head, *lines])


def designs_of(name: str) -> list[dict[str, Any]]:
    """The designs of a study, with what they save."""
    rows = table(name, "designs").rows(named=True)
    plain = next((row for row in rows if row["name"] == "uniform"), None)
    for row in rows:
        saves = plain and row["coefficient_kbit"]
        row["saves_percent"] = 100 * (1 - row["coefficient_kbit"] / plain["coefficient_kbit"]) if saves else None
    return rows


def designs(names: tuple[str, ...]) -> str:
    """The designs of some studies, on held-out frames."""
    head = (
        "| sensor | design | coefficients, kbit | less than uniform, % | DSP | BRAM, estimated | LUT, estimated "
        "| total on held-out frames over float's, % | RTL words compared | that differ |"
    )
    lines = [head, "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|"]
    for name in names:
        sensor = load_study(ROOT / example(name)).design.sensor
        pitches = f"{1e3 * sensor.pitch_x:g}×{1e3 * sensor.pitch_y:g} mm"
        for row in designs_of(name):
            if row["coefficient_kbit"] is None:
                continue
            saves = "" if row["saves_percent"] is None else f"{row['saves_percent']:.1f}"
            verified = [f"{row[key]:,}" if row.get(key) is not None else "" for key in ("rtl_words", "rtl_differ")]
            lines.append(
                f"| {sensor.rows}×{sensor.columns}, {pitches} | {row['name']} "
                f"| {row['coefficient_kbit']:.1f} | {saves} | {row['DSP']:.0f} | {row['BRAM']:.0f} | {row['LUT']:,.0f} "
                f"| {row[f'{CHANGE}_held_out']:+.2f} | {' | '.join(verified)} |"
            )
    return "\n".join(lines)


def lengths(out: str) -> str:
    """Word lengths of what was found, signal by signal."""
    formats = load(PLACE / out / "designs" / "least_coefficient_kbit.toml").design.formats
    lines = ["| signal | bits |", "|---|---:|", f"| vector fraction | {formats.vector_fraction} |"]
    return "\n".join([*lines, *(f"| `{signal}` | {bits} |" for signal, bits in formats.signals)])


def chance(out: str) -> str:
    """Results of NSGA-II and of random choice."""
    lines = [
        "| | designs measured to the end | close to float | least coefficients of those, kbit |",
        "|---|---:|---:|---:|",
    ]
    for label, name in (("NSGA-II", "trials"), ("by chance", "baseline")):
        complete = table(out, name).filter(state="complete")
        close = complete.filter(pl.col(CHANGE) <= 5)
        least = f"{close['coefficient_kbit'].min():.1f}" if len(close) else "none"
        lines.append(f"| {label} | {len(complete)} of {len(table(out, name))} | {len(close)} | {least} |")
    return "\n".join(lines)


def sentence(out: str) -> str:
    """The answer on top of a report."""
    tables = {path.stem: pl.read_parquet(path) for path in (PLACE / out / "tables").iterdir()}
    said: str = summary(tables, load_study(ROOT / example(out)).design)
    return "> " + said


def layouts() -> str:
    """Placed and routed designs with their estimates."""
    rows = [row for row in designs_of("placed") if row.get("placed_LUT") is not None]
    lines = ["| design | LUT: estimate, placed | FF | DSP | BRAM | MHz, one seed |", "|---|---:|---:|---:|---:|---:|"]
    for row in rows:
        pairs = [f"{row[name]:,.0f}, {row[f'placed_{name}']:,.0f}" for name in ("LUT", "FF", "DSP", "BRAM")]
        lines.append(f"| {row['name']} | {' | '.join(pairs)} | {row['fmax_mhz']:.1f} |")
    return "\n".join(lines)


def shortened() -> str:
    """A shorter search of the tutorial's study, for comparisons that take several runs."""
    text = (ROOT / example(TUTORIAL)).read_text().replace('config = "', f'config = "{ROOT}/examples/')
    text = text.replace("[search]\n", "[search]\ngenerations = 4\nbaseline = false\n").replace(
        "[verify]\nframes = 200\n", ""
    )
    (PLACE / "short.toml").write_text(text)
    return str(PLACE / "short.toml")


def runs() -> tuple[dict[str, Any], str]:
    """One worker against two, and two kills: what was measured, and the same for the page."""
    file = shortened()
    both, alone = study(file, "both", 2), study(file, "alone", 1)
    study(file, "killed", 2, (both.seconds / 3, both.seconds / 3))
    same = {run: content(run) == content("both") for run in ("alone", "killed")}
    efficiency, told = alone.seconds / 2 / both.seconds, {True: "the same bytes", False: "OTHER BYTES"}
    said = (
        f"A search of four generations, all else as in `{example(TUTORIAL)}`: {both.seconds:.0f} s with two workers, "
        f"{alone.seconds:.0f} s with one: two are {100 * efficiency:.0f} % efficient. All processes together took "
        f"{both.megabytes:,.0f} MB. One worker makes {told[same['alone']]}, and so does a run that was killed twice: "
        f"{told[same['killed']]}."
    )
    facts = {"two": vars(both), "one": vars(alone), "efficiency": efficiency, "same_bytes": same}
    return facts, said


def times() -> tuple[dict[str, Any], str]:
    """Times that the studies report."""
    pattern = r"Done by 2 processes: ([\d,.]+) s in all. Memory of the largest process: ([\d,]+) MB"
    lines, facts = ["| study | minutes on two cores | largest process, MB |", "|---|---:|---:|"], {}
    for name in STUDIES:
        found = re.search(pattern, (PLACE / name / "times.html").read_text())
        assert found
        seconds, megabytes = (float(number.replace(",", "")) for number in found.groups())
        facts[name] = {"seconds": seconds, "megabytes": megabytes, "designs": designs_of(name)}
        lines.append(f"| `{example(name)}` | {seconds / 60:.1f} | {megabytes:,.0f} |")
    return facts, "\n".join(lines)


def main() -> None:
    """Run everything, and publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", action="store_true", help="the studies whose reports are there are not run again")
    parser.add_argument("--no-place", action="store_true", help="leave out place and route")
    options = parser.parse_args()
    if not options.keep:
        shutil.rmtree(PLACE, ignore_errors=True)
    PLACE.mkdir(parents=True, exist_ok=True)
    for name in STUDIES:
        if not (PLACE / name).exists():
            study(example(name), name, 2)
    (studies, table_of_times), (facts, told) = times(), runs()
    store("bits", {"studies": studies, **facts})
    insert("bits times", f"{table_of_times}\n\n{told}", PAGE)
    for name, text in {
        "answer": sentence(TUTORIAL), "cascade": cascade(TUTORIAL), "uniform": uniform(TUTORIAL),
        "designs": designs((TUTORIAL,)), "lengths": lengths(TUTORIAL), "chance": chance(TUTORIAL),
        "sensors": designs(STUDIES),
    }.items():  # fmt: skip
        insert(f"bits {name}", text, PAGE)
    if not options.no_place:
        placed("hertz")
        insert("bits placed", layouts(), PAGE)


if __name__ == "__main__":
    main()
