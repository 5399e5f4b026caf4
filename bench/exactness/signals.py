"""Every signal of the default design: use of its word, and precision.

``python -m bench.exactness.signals`` writes ``bench/results/signals.json`` and two tables in docs/numerics.md.  The
contacts are random in shape, place, size, friction, direction and strength.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import polars as pl

from bench.publish import insert, store
from tfra.model.cover.scenes import SENSORS, contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.signals.attaining import attaining
from tfra.study.signals.ranges import broken, ranges
from tfra.study.signals.stages import stage_errors

PAGE = "docs/numerics.md"
DESIGN = TfraDesign(SENSORS["10×10, 4×2 mm, h 3 mm"])
SEED = 2025


def main() -> None:
    """Measure and publish; exits with 1 if a signal exceeded its word."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=4000)
    count = parser.parse_args().contacts
    contacts = contact_codes(DESIGN, count, SEED)
    wild = np.concatenate([wild_codes(DESIGN, count, SEED), directed_codes(DESIGN)])
    tables = [ranges(DESIGN, [codes]) for codes in (contacts, wild)]
    reached = attaining(DESIGN).table()
    errors = stage_errors(DESIGN, [contacts])
    record: dict[str, Any] = {"contacts": count, "seed": SEED, "left_out": errors.left_out}
    record |= {"contact_ranges": tables[0].to_dicts(), "other_ranges": tables[1].to_dicts()}
    record |= {"attaining": reached.to_dicts(), "errors": errors.errors().to_dicts()}
    store("signals", record | {"decisions": errors.decisions().to_dicts()})
    insert("ranges", used(*tables, reached), PAGE)
    insert("stages", exactness(errors.errors()), PAGE)
    if any(len(broken(table)) for table in tables):
        raise SystemExit(1)


def used(contacts: pl.DataFrame, wild: pl.DataFrame, reached: pl.DataFrame) -> str:
    """Markdown: bits that signals need, and how much of their bounds frames reach."""
    lines = [
        "| stage | signal | word | bits | contacts | other frames | rounded | largest found, of the bound | possible |",
        "|---|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    shares = {row["signal"]: row for row in reached.iter_rows(named=True)}
    other = dict(wild.select("signal", "bits_needed").iter_rows())
    for row in contacts.iter_rows(named=True):
        name = row["signal"]
        rounded = "" if row["rounded"] is None else f"{row['rounded'] / row['words']:.0%}"
        found = shares.get(name)
        share = f"{found['share']:.1%} | {found['ceiling'] / found['bound']:.1%}" if found else " | "
        cells = row["stage"], f"`{name}`", row["word"], row["bits"], row["bits_needed"], other[name], rounded, share
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def exactness(errors: pl.DataFrame) -> str:
    """Markdown: errors of every signal from the codes on, and those of its stage alone."""
    lines = [
        "| stage | signal | SQNR, dB | rms, LSB | worst, LSB | SQNR of the stage alone, dB | rms, LSB | worst, LSB |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for signal in errors["signal"].unique(maintain_order=True):
        rows = errors.filter(pl.col("signal") == signal).to_dicts()
        lines.append(f"| {rows[0]['stage']} | `{signal}` | {' | '.join(map(_error, rows))} |")
    return "\n".join(lines)


def _error(row: dict[str, Any]) -> str:
    if row["exact"]:
        return "exact | 0 | 0"
    return f"{row['sqnr_db']:.1f} | {row['rms_error_lsb']:.3g} | {row['max_error_lsb']:.3g}"


if __name__ == "__main__":
    main()
