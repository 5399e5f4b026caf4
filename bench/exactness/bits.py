"""Runs the default studies and writes their results into docs/how_many_bits.md and docs/skins.md.

``python -m bench.exactness.bits [--keep]`` takes half an hour on two idle cores; with ``--keep`` the studies whose
reports are there are not run again.
"""

import argparse
import shutil
import subprocess
import sys

import polars as pl

from bench.publish import ROOT, insert
from tfra.report.table import number
from tfra.study.errors.cascade import Step, View
from tfra.study.report.labels import QUANTITIES, STEPS
from tfra.study.report.summary import HEADLINE, summary
from tfra.study.search.evaluate import CHANGE
from tfra.study.skins import page
from tfra.study.skins.studyfile import SkinStudy
from tfra.study.studyfile import load_study

PAGE = "docs/how_many_bits.md"
PLACE = ROOT / "build" / "studies"
STUDIES = ("hertz", "rectangle", "skin")
TUTORIAL = "skin"
RESOURCES = ("LUT", "FF", "BRAM")
FINGERS = "fingers"
"""That of a skin with many contacts."""
LEARNED = "learned"
"""That of the learned estimator, whose designs are synthesised."""


def example(name: str) -> str:
    """The file of a default study."""
    return f"examples/study_{name}.toml"


def run(name: str) -> None:
    """Run a default study; raises ``CalledProcessError`` if it fails."""
    command = [sys.executable, "-m", "tfra.cli", "study", example(name), "--out", str(PLACE / name), "--workers", "2"]
    subprocess.run([*command, "--work", str(PLACE / f"{name}.work")], cwd=ROOT, check=True)


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
            row = found.filter(quantity=str(quantity), step=str(step), view=str(view)).row(0, named=True)
            cells.append(f"{number(row['median'])} / {number(row['p95'])}")
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _kind(quantity: str) -> str:
    kind = QUANTITIES[quantity]
    return f"{kind.label}, {kind.unit}: median / 95th percentile".replace("|", "\\|")


def uniform(out: str) -> str:
    """Growth of the total error with uniform products of even lengths, by their bits."""
    complete = table(out, "uniform_trials").filter(state="complete").filter(pl.col("bits") % 2 == 0)
    rows = complete.sort("bits").iter_rows(named=True)
    head = ["| bits | growth of the total, worst quantity, % | coefficients, kbit | DSP |", "|---:|---:|---:|---:|"]
    lines = [
        f"| {row['bits']} | {row[CHANGE]:.2f} | {row['coefficient_kbit']:.1f} | {row['DSP']:.0f} |" for row in rows
    ]
    return "\n".join([*head, *lines])


def designs(names: tuple[str, ...]) -> str:
    """The designs of some studies, on held-out frames."""
    head = (
        "| sensor | design | coefficients, kbit | less than uniform, % | DSP | BRAM, estimated | LUT, estimated "
        "| total on held-out frames over float's, % | RTL words compared | that differ |"
    )
    lines = [head, "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|"]
    for name in names:
        sensor = load_study(ROOT / example(name)).project.design.sensor
        pitches = f"{1e3 * sensor.pitch_x:g}×{1e3 * sensor.pitch_y:g} mm"
        rows = [row for row in table(name, "designs").rows(named=True) if row["coefficient_kbit"] is not None]
        plain = next((row["coefficient_kbit"] for row in rows if row["name"] == "uniform"), None)
        for row in rows:
            kbit = row["coefficient_kbit"]
            saves = f"{100 * (1 - kbit / plain):.1f}" if plain and kbit else ""
            verified = [f"{row[key]:,}" if row.get(key) is not None else "" for key in ("rtl_words", "rtl_differ")]
            lines.append(
                f"| {sensor.rows}×{sensor.columns}, {pitches} | {row['name']} | {kbit:.1f} | {saves} "
                f"| {row['DSP']:.0f} | {row['BRAM']:.0f} | {row['LUT']:,.0f} "
                f"| {row[f'{CHANGE}_held_out']:+.2f} | {' | '.join(verified)} |"
            )
    return "\n".join(lines)


def synthesised(out: str) -> str:
    """The designs of a study that were synthesised, beside their estimates."""
    head = "| design | products, kbit | coefficients, kbit | total on held-out frames over float's, % | DSP "
    lines = [
        f"{head}| {' | '.join(f'{name}, estimated' for name in RESOURCES)} |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in table(out, "designs").drop_nulls("synthesised_LUT").rows(named=True):
        used = [f"{row[f'synthesised_{name}']:,}, {row[name]:,.0f}" for name in RESOURCES]
        lines.append(
            f"| {row['name']} | {row['multiplier_kbit']:,.0f} | {row['coefficient_kbit']:.0f} "
            f"| {row[f'{CHANGE}_held_out']:+.2f} | {row['DSP']:.0f} | {' | '.join(used)} |"
        )
    return "\n".join(lines)


def sentence(out: str) -> str:
    """The answer on top of a report, its lines as a list."""
    tables = {path.stem: pl.read_parquet(path) for path in (PLACE / out / "tables").iterdir()}
    study = load_study(ROOT / example(out))
    lines = page.summary(tables, study.skin) if isinstance(study, SkinStudy) else summary(tables, study.design)
    return "\n".join(f"> - {line}" for line in lines)


def main() -> None:
    """Run everything, and publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", action="store_true", help="the studies whose reports are there are not run again")
    if not parser.parse_args().keep:
        shutil.rmtree(PLACE, ignore_errors=True)
    PLACE.mkdir(parents=True, exist_ok=True)
    for name in (*STUDIES, FINGERS, LEARNED):
        if not (PLACE / name).exists():
            run(name)
    insert("bits answer", sentence(TUTORIAL), PAGE)
    insert("skins study", sentence(FINGERS), "docs/skins.md")
    insert("bits cascade", cascade(TUTORIAL), PAGE)
    insert("bits uniform", uniform(TUTORIAL), PAGE)
    insert("bits sensors", designs(STUDIES), PAGE)
    insert("bits learned answer", sentence(LEARNED), PAGE)
    insert("bits learned", synthesised(LEARNED), PAGE)


if __name__ == "__main__":
    main()
