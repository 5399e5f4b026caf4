"""All tables of a study, by the functions that a study calls, of a few frames."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import polars as pl
import pytest

from tests.study.definitions import complete, one_after_another, tables_of
from tfra.families import DEFAULT, find
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.designs import Described, Named
from tfra.study.errors.comparisons import converters, sensitivity, uniform, variants
from tfra.study.errors.variation import Variation
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.search import costs
from tfra.study.search.evaluate import CHANGE, Evaluation
from tfra.study.search.search import Search, trial_table
from tfra.study.search.space import Space
from tfra.study.search.trials import Trials, sqlite
from tfra.study.tasks import Comparison, Errors, Estimators, Signals

FORCE = "force_difference_percent_of_true_force"
COSTS = ("coefficient_kbit", "latency_cycles")
LIMIT = "phi_deg"
"""An error that is measured, but no objective."""
SPACE = Space({"coefficient": (8, 10, 12, 14, 18), "operand.force": (10, 12, 14, 18), "mac_lanes": (4, 8, 16)})
SIGNALS = ("coefficient.normal", "scalar", "cordic")
"""Those that are shortened; a shorter ``cordic`` does not fit."""


def make(design: TfraDesign, definition: Definition, folder: Path) -> dict[str, pl.DataFrame]:
    """Every table, of a few variations and trials; ``folder`` gets frames and trials."""
    frames = complete(folder / "frames", definition)
    comparisons = [Comparison(name, frames, some) for name, some in variations(design).items()]
    tables: dict[str, pl.DataFrame] = {}
    beside = Estimators((("one", design), ("other", replace(design, search=replace(design.search, steps=10)))), frames)
    for task in (Errors(design, frames), Signals(design, frames), beside, *comparisons):
        tables |= tables_of(task)
    for name, sampler in (("trials", "nsga2"), ("baseline", "random")):
        search = Search(SPACE, (CHANGE, *COSTS), generations=2, size=4, seed=1, sampler=sampler)
        tables[name] = trials(search, evaluation(design, frames), folder)
    tables["designs"] = designs(design, frames)
    return tables


def variations(design: TfraDesign) -> dict[str, tuple[Variation, ...]]:
    """What is compared, by table: each has one that does not fit, but for variants."""
    chosen = tuple(each for each in sensitivity(design, DEFAULT, (1, 4)) if each.facts["signal"] in SIGNALS)
    short = replace(design, formats=replace(design.formats, name="custom", operand=14, signals=()))
    return {
        "uniform": uniform(design, (10, 12, 14, 18, 28), DEFAULT),
        "sensitivity": chosen,
        "converter": converters(short, (8, 12, 16), (0.0, 0.01)),
        "variants": variants(design, (50, 100), (1.0,)),
    }


def evaluation(design: TfraDesign, frames: FrameSet) -> Evaluation:
    return Evaluation(design, frames, COSTS, find("ecp5-45"), (FORCE, LIMIT))


def trials(search: Search, measure: Evaluation, folder: Path) -> pl.DataFrame:
    store = Trials(sqlite(folder / "trials.sqlite"), search.sampler)
    finished = sorted(search.run(measure, store, one_after_another), key=lambda trial: trial.number)
    return trial_table(finished, search, measure.quantities)


def designs(design: TfraDesign, frames: FrameSet) -> pl.DataFrame:
    """Float arithmetic and named designs, two of them placed; resources, which take long, are of no core."""
    lengths = {"base": (18, 18), "uniform": (14, 14), "mixed": (10, 14)}
    named = tuple(
        Named(name, Space.design(design, {"coefficient": coefficient, "operand": operand}))
        for name, (coefficient, operand) in lengths.items()
    )
    quick = SimpleNamespace(total={"LUT": 20_000, "FF": 15_000, "BRAM": 51})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(costs, "estimate", lambda design, family: quick)
        table = tables_of(Described((None, *named), evaluation(design, frames)))["designs"]
    placed = pl.when(pl.col("name").is_in(["base", "mixed"]))
    columns = {f"placed_{name}": placed.then(1.2 * pl.col(name)) for name in ("LUT", "FF", "DSP", "BRAM")}
    columns |= {"fmax_mhz": placed.then(84.25), "part": placed.then(pl.lit("LFE5U-45F"))}
    return table.with_columns(**columns, rtl_frames=pl.lit(200), rtl_words=pl.lit(8_400), rtl_differ=pl.lit(0))
