"""All tables of a study, by the functions that a study calls, of a few frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl

from tfra.model.choices import Search as Sweep
from tfra.model.converter import convert
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.cascade import Cascade, Step, View
from tfra.study.errors.statistics import errors, flagged, flips
from tfra.study.frames.block import Block, Part
from tfra.study.frames.frameset import Definition
from tfra.study.search.search import Measured, Search, front
from tfra.study.search.space import Point, Space
from tfra.study.search.trials import COMPLETE, UNFIT, Trials, sqlite
from tfra.study.signals.ranges import ranges
from tfra.study.signals.stages import stage_errors
from tfra.study.workers import one_after_another

FORCE = "force_difference_percent_of_true_force"
ERROR = f"{FORCE}.p95"
OBJECTIVES = (ERROR, "coefficient_kbit", "dsp")
SPACE = Space({"coefficient": (10, 12, 14, 16, 18), "operand.force": (10, 12, 14, 18), "mac_lanes": (4, 8, 16)})


def make(
    design: TfraDesign,
    definition: Definition,
    folder: Path,
    signals: Sequence[str] = ("coefficient.normal", "scalar"),
    uniform: Iterable[int] = (12, 14, 18),
    converter: Sequence[int] = (8, 12),
    noise: Sequence[float] = (0.0, 0.01),
    generations: int = 2,
    size: int = 4,
) -> dict[str, pl.DataFrame]:
    """Every table; ``folder`` gets the trials."""
    blocks = {part: [definition.make(part, n) for n in range(definition.blocks(part))] for part in Part}
    train = blocks[Part.TRAIN]
    tables = {}
    for name, table in (("errors", errors), ("flagged", flagged), ("flips", flips)):
        made = [table(scores(design, some)).insert_column(0, labelled("part", part)) for part, some in blocks.items()]
        tables[name] = pl.concat(made)
    codes = [convert(design, block.noisy) for block in train]
    stages = stage_errors(design, codes)
    tables |= {"stages": stages.errors(), "decisions": stages.decisions(), "ranges": ranges(design, codes)}
    tables["uniform"] = pl.concat([uniform_rows(design, train, bits) for bits in uniform])
    tables["sensitivity"] = pl.concat(list(shorter_rows(design, train, signals)))
    tables["converter"] = pl.concat(list(converter_rows(design, train, converter, noise)))
    tables["variants"] = pl.concat(list(variant_rows(design, train)))
    tables["trials"] = trials(design, train, folder, generations, size)
    tables["designs"] = designs(design, train, blocks[Part.HELD_OUT])
    return tables


def scores(design: TfraDesign, blocks: Sequence[Block]) -> pl.DataFrame:
    return pl.concat([Cascade(design)(block) for block in blocks])


def labelled(name: str, value: Any) -> pl.Series:
    return pl.lit(str(value) if isinstance(value, Part) else value).alias(name)


def measured(design: TfraDesign, blocks: Sequence[Block], steps: Sequence[Step], **columns: Any) -> pl.DataFrame:
    """Errors of some steps behind columns that say of what."""
    found = errors(scores(design, blocks)).filter(pl.col("step").is_in(list(steps)))
    return found.select(*(labelled(name, value) for name, value in columns.items()), pl.all())


def costs(design: TfraDesign) -> dict[str, float]:
    """Memory and multipliers, roughly."""
    lane = max(design.formats.bits(f"coefficient.{name}") for name in ("c33", "normal", "pinv1"))
    return {"coefficient_kbit": lane * 22.9, "dsp": float(design.architecture.mac_lanes + 12)}


def with_formats(design: TfraDesign, **changes: Any) -> TfraDesign:
    return replace(design, formats=replace(design.formats, name="custom", **changes))


def uniform_rows(design: TfraDesign, blocks: Sequence[Block], bits: int) -> pl.DataFrame:
    other = with_formats(design, coefficient=bits, operand=bits, vector_fraction=min(14, bits // 2))
    return measured(other, blocks, [Step.ARITHMETIC], bits=bits).with_columns(
        **{k: pl.lit(v) for k, v in costs(other).items()}
    )


def shorter_rows(design: TfraDesign, blocks: Sequence[Block], signals: Sequence[str]) -> Iterator[pl.DataFrame]:
    for signal in signals:
        for shorter in (1, 4):
            bits = design.formats.bits(signal)
            try:
                other = with_formats(design, signals=((signal, bits - shorter),))
            except ValueError:
                continue
            yield measured(other, blocks, [Step.ARITHMETIC], signal=signal, bits=bits, shorter=shorter)


def converter_rows(
    design: TfraDesign, blocks: Sequence[Block], converter: Sequence[int], noise: Sequence[float]
) -> Iterator[pl.DataFrame]:
    for share in noise:
        some = [more_noise(block, share) for block in blocks]
        for bits in converter:
            other = replace(design, adc=replace(design.adc, bits=bits))
            steps = [Step.NOISE, Step.CONVERTER]
            yield measured(other, some, steps, converter_bits=bits, noise_share_of_peak=share)


def more_noise(block: Block, share: float) -> Block:
    """The block with noise of some kind: here as a wave over the taxels."""
    peak = abs(block.stress).max(axis=(1, 2), keepdims=True)
    wave = [[(-1.0) ** (i * j + j // 2) for j in range(block.stress.shape[2])] for i in range(block.stress.shape[1])]
    return replace(block, noisy=(block.stress + share * peak * wave).astype("float32"))


def variant_rows(design: TfraDesign, blocks: Sequence[Block]) -> Iterator[pl.DataFrame]:
    for steps in (50, 100):
        other = replace(design, search=Sweep(steps, design.search.tolerance))
        yield measured(other, blocks, [Step.ARITHMETIC], variant="steps", value=str(steps))
    for tolerance in (1.0,):
        other = replace(design, search=Sweep(design.search.steps, tolerance))
        yield measured(other, blocks, [Step.ARITHMETIC], variant="plateau_tolerance", value=f"{tolerance:g}")


def added(design: TfraDesign, blocks: Sequence[Block]) -> Any:
    """95th percentile of what arithmetic adds."""
    row = errors(scores(design, blocks)).filter(quantity=FORCE, step=Step.ARITHMETIC, view=View.OWN)
    return row["p95"].item()


def trials(design: TfraDesign, blocks: Sequence[Block], folder: Path, generations: int, size: int) -> pl.DataFrame:
    def measure(point: Point) -> Measured:
        try:
            other = SPACE.design(design, point)
        except ValueError as error:
            return Measured(UNFIT, {}, str(error))
        return Measured(COMPLETE, {ERROR: added(other, blocks), **costs(other)})

    search = Search(SPACE, OBJECTIVES, generations, size, seed=1)
    found = sorted(
        search.run(measure, Trials(sqlite(folder / "trials.sqlite"), "x"), one_after_another), key=lambda t: t.number
    )
    best = {trial.number for trial in front(found, OBJECTIVES)}
    rows = [
        {"number": t.number, "generation": t.number // size, "state": t.state, **SPACE.point(t.indices)}
        | {name: t.values.get(name) for name in OBJECTIVES}
        | {"front": t.number in best, "reason": t.reason}
        for t in found
    ]
    return pl.DataFrame(rows, infer_schema_length=None)


def designs(design: TfraDesign, train: Sequence[Block], held_out: Sequence[Block]) -> pl.DataFrame:
    rows: list[dict[str, Any]] = []
    for name, bits, fmax in (("base", 18, 84.2), ("uniform 14", 14, None), ("mixed", 12, 91.7)):
        other = with_formats(design, coefficient=bits, operand=max(bits, 14))
        words = f"coefficients {bits} bits, operands {max(bits, 14)} bits"
        row = {"name": name, "formats": words, ERROR: added(other, train), f"{ERROR}_held_out": added(other, held_out)}
        rows.append(row | costs(other) | {"lut": 20e3 + 100 * bits, "fmax_mhz": fmax})
    return pl.DataFrame(rows)
