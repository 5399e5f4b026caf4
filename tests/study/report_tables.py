"""All tables of a study, by the functions that a study calls, of a few frames."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl

from tests.study.definitions import tables_of
from tfra.families import find
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.comparisons import converters, sensitivity, uniform, variants
from tfra.study.errors.variation import Comparison, Variation
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.report.labels import CLOSE_PERCENT
from tfra.study.run import trial_table
from tfra.study.search.evaluate import CHANGE, Evaluation
from tfra.study.search.search import Search
from tfra.study.search.space import Space
from tfra.study.search.trials import Trials, sqlite
from tfra.study.tasks import Errors, Signals
from tfra.study.workers import one_after_another

FORCE = "force_difference_percent_of_true_force"
COSTS = ("coefficient_kbit", "latency_cycles")
LIMIT = "phi_deg"
"""An error that is measured, but no objective."""
SPACE = Space({"coefficient": (8, 10, 12, 14, 18), "operand.force": (10, 12, 14, 18), "mac_lanes": (4, 8, 16)})
SIGNALS = ("coefficient.normal", "scalar", "cordic")
"""Those that are shortened; a shorter ``cordic`` does not fit."""


def make(design: TfraDesign, definition: Definition, folder: Path, few: bool = True) -> dict[str, pl.DataFrame]:
    """Every table; ``folder`` gets frames and trials.  A ``few`` of all variations, and of all trials."""
    frames = FrameSet.create(folder / "frames", definition)
    frames.complete()
    comparisons = [Comparison(name, frames, some) for name, some in variations(design, few).items()]
    tables: dict[str, pl.DataFrame] = {}
    for task in (Errors(design, frames), Signals(design, frames), *comparisons):
        tables |= tables_of(task)
    generations, size = (2, 4) if few else (8, 24)
    for name, sampler in (("trials", "nsga2"), ("baseline", "random")):
        search = Search(SPACE, (CHANGE, *COSTS), generations, size, seed=1, sampler=sampler)
        tables[name] = trials(search, evaluation(design, frames, Part.TRAIN), folder)
    tables["designs"] = designs(design, frames)
    return tables


def variations(design: TfraDesign, few: bool) -> dict[str, tuple[Variation, ...]]:
    """What is compared, by table: each has one that does not fit, but for variants."""
    if not few:
        return {
            "uniform": uniform(design, range(10, 29, 2)),
            "sensitivity": sensitivity(design),
            "converter": converters(design),
            "variants": variants(design),
        }
    chosen = tuple(
        each for each in sensitivity(design) if each.facts["signal"] in SIGNALS and each.facts["shorter"] != 2
    )
    short = replace(design, formats=replace(design.formats, name="custom", operand=14, signals=()))
    return {
        "uniform": uniform(design, (10, 12, 14, 18, 28)),
        "sensitivity": chosen,
        "converter": converters(short, (8, 12, 16), (0.0, 0.01)),
        "variants": variants(design, (50, 100), (1.0,)),
    }


def evaluation(design: TfraDesign, frames: FrameSet, part: Part) -> Evaluation:
    return Evaluation(design, frames, COSTS, find("ecp5-45"), (FORCE, LIMIT), part=part)


def trials(search: Search, evaluate: Evaluation, folder: Path) -> pl.DataFrame:
    store = Trials(sqlite(folder / "trials.sqlite"), search.sampler)
    found = sorted(search.run(evaluate, store, one_after_another), key=lambda trial: trial.number)
    return trial_table(found, search, evaluate.quantities)


def designs(design: TfraDesign, frames: FrameSet) -> pl.DataFrame:
    """Float arithmetic and named designs; what takes long, their resources, are figures of no core."""
    known = {part: evaluation(design, frames, part) for part in Part}
    exact = {part: known[part].exact() for part in Part}
    rows = [design_row("float", "float64 on the same codes", exact, {}, exact)]
    for name, coefficient, operand, placed in (
        ("base", 18, 18, True),
        ("uniform", 14, 14, False),
        ("mixed", 10, 14, True),
    ):
        point = {"coefficient": coefficient, "operand": operand}
        other = Space.design(design, point)
        words = (
            f"coefficients of {coefficient} bits, operands of {operand} bits, vectors with as many bits below one code"
        )
        found = {part: known[part].errors(other, frames.definition.blocks(part)) for part in Part}
        lut, ff = 20e3 + 100 * coefficient, 15e3 + 90 * coefficient
        costs = {**known[Part.TRAIN].cost_values(other), "LUT": lut, "FF": ff, "DSP": 17.0, "BRAM": 51.0}
        costs |= (
            {"placed_LUT": 1.2 * lut, "placed_FF": 1.1 * ff, "placed_DSP": 17.0, "placed_BRAM": 52.0} if placed else {}
        )
        costs |= {"fmax_mhz": 84.25 + coefficient} if placed else {}
        rows.append(design_row(name, words, found, costs, exact))
    return pl.DataFrame(rows, infer_schema_length=None)


RESOURCES = ("LUT", "FF", "DSP", "BRAM")
NOTHING: dict[str, Any] = dict.fromkeys(
    [*COSTS, *RESOURCES, *(f"placed_{name}" for name in RESOURCES), "fmax_mhz", "part", "rtl_frames", "rtl_words"]
)


def design_row(
    name: str, words: str, found: dict[Part, Any], costs: dict[str, float], exact: dict[Part, Any]
) -> dict[str, Any]:
    row = {"name": name, "formats": words, "file": None if name == "float" else f"designs/{name}.toml"}
    row |= found[Part.TRAIN] | {f"{key}_held_out": value for key, value in found[Part.HELD_OUT].items()}
    most = {key: value * (1 + CLOSE_PERCENT / 100) for key, value in exact[Part.HELD_OUT].items()}
    rest = NOTHING | costs | {"part": "LFE5U-45F" if "fmax_mhz" in costs else None, "rtl_differ": None}
    rest |= {"rtl_frames": 200, "rtl_words": 8_400, "rtl_differ": 0} if costs else {}
    return row | rest | {"within": all(found[Part.HELD_OUT][key] <= value for key, value in most.items())}
