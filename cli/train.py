"""``tfra train``: the learned estimator of a sensor."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tfra.cli.common import Config, Json, Seed, WorkFolder, failures, print_json, progress
from tfra.cli.messages import print_error
from tfra.runtime.errors import InputError, Notice, require

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.codegen.config.weights import Trained
    from tfra.train.known import Known
    from tfra.train.loop import State
    from tfra.train.rounding import Rounding
    from tfra.train.run import Advance

KINDS = ("missed", "invented")
"""Shares of a skin's contacts."""

Out = Annotated[Path, typer.Option(metavar="WEIGHTS.npz", help="Where the weights go.")]
Force = Annotated[bool, typer.Option("--force", help="Replace better weights of the same sensor, too.")]
Minutes = Annotated[
    float | None, typer.Option(min=0.01, max=1e5, metavar="M", help="Time of the training itself, instead of --steps.")
]
Steps = Annotated[
    int | None, typer.Option(min=1, max=10**9, metavar="N", help="Steps of 512 frames; default: 120,000.")
]
CalibrationFile = Annotated[
    Path | None, typer.Option("--calibration", metavar="CAL.toml", help="Train for the one sensor of this file.")
]
Rounded = Annotated[
    bool, typer.Option("--rounded", help="Train CONFIG's weights on, with the roundings of its core; 40,000 steps.")
]
Channels = Annotated[
    tuple[int, int] | None,
    typer.Option(
        min=1,
        max=1024,
        metavar="C1 C2",
        help="Units in each layer, times four mirrors. Default: 48 24, for a skin 96 48.",
    ),
]


def train(
    config: Config,
    out: Out,
    minutes: Minutes = None,
    steps: Steps = None,
    seed: Seed = 1,
    channels: Channels = None,
    calibration: CalibrationFile = None,
    rounded: Rounded = False,
    work: WorkFolder = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Train the learned estimator of CONFIG's sensor on simulated contacts, and tell its errors on other ones.

    Of a skin it is that of a window: the same weights serve every skin with this pitch, cover and window.  Those of a
    calibration are for one array, with its errors of gains, its cover and its dead taxels.  Better weights of the
    same sensor are kept, and the new ones written beside them.  Rounded weights are for the word lengths of [formats].
    """
    require("tfra train", "train", "threadpoolctl")
    if minutes is not None and steps is not None:
        raise InputError("tfra train", "--minutes", "and --steps exclude each other")
    from tfra.codegen.config.read import load, load_tfra
    from tfra.codegen.config.weights import write_weights
    from tfra.runtime.outputs import check_file
    from tfra.train.known import UNKNOWN
    from tfra.train.loop import DivergedError
    from tfra.train.rounding import EXACT
    from tfra.train.run import Budget, run

    project = load(config) if rounded else load_tfra(config)
    window = project.skin is not None
    rounding = _rounding(project, channels) if rounded else EXACT
    units = rounding.counts or channels or ((96, 48) if window else (48, 24))
    budget = Budget(units, seed, steps, minutes, window)
    known = _known(calibration, project) if calibration else UNKNOWN
    inputs = [
        config,
        *([calibration] if calibration else []),
        *([config.parent / str(project.weights)] if rounded else []),
    ]
    check_file(out, ".npz", "train", inputs)
    with failures("train", DivergedError, hint=": another --seed may help"):
        trained = run(project.design.sensor, budget, work or Path(f"{out}.work"), _progress, known, rounding)
    kept = None if force else _better(out, trained)
    to = out.with_suffix(".new.npz") if kept else out
    write_weights(to, trained)
    if json:
        print_json({"out": str(to), "threshold": trained.threshold, "held_out": dict(trained.held_out)})
    else:
        for line in _table(dict(trained.held_out)):
            typer.echo(line)
        typer.echo(f"{to}: {units[0]}/{units[1]} units, {trained.prior['training.steps']:,} steps")
    if kept:
        print_error(f"tfra train: {InputError(out, '', f'{kept}; the new ones are {to.name}, --force replaces')}")
        raise typer.Exit(1)


def _rounding(project: Project, channels: tuple[int, int] | None) -> Rounding:
    """The word lengths of CONFIG's core; raises ``InputError`` where rounding has no weights or nothing to do."""
    from tfra.model.fixed.learned.design import LearnedDesign
    from tfra.model.fixed.learned.operators import LONG
    from tfra.train.rounding import SIGNALS, Rounding

    design = project.design
    if not isinstance(design, LearnedDesign):
        raise InputError(
            project.path, "estimator.kind", '"learned" is needed, with the weights to begin with, by --rounded'
        )
    if channels:
        raise InputError("tfra train", "--channels", "are those of CONFIG's weights, by --rounded")
    shortest = min(design.formats.bits(name) for name in SIGNALS)
    if shortest >= LONG:
        reason = f"words of {shortest} bits or more lose nothing that a training could learn, by --rounded"
        raise InputError(project.path, "formats", reason)
    return Rounding(design)


def _known(file: Path, project: Project) -> Known:
    """What the calibration in ``file`` says of CONFIG's array; raises ``InputError`` where a training can't use it."""
    from tfra.codegen.config.complaints import blame
    from tfra.codegen.config.cover import require_few_modes
    from tfra.model.cover.layer import ElasticLayer
    from tfra.recordings.calibration import SURE, read_calibration
    from tfra.train.known import Known

    if project.skin:
        raise InputError("tfra train", "--calibration", "is of one array, a window's weights serve every skin")
    sensor = project.design.sensor
    found = read_calibration(file, sensor, project.input)
    cover = found.cover
    if found.gain_error is None and cover is None and not found.dead.any():
        raise InputError(file, "", "has neither gain_error nor cover nor dead taxels: nothing that a training takes")
    known = Known.of(found, sensor)
    with blame(file, "cover"):
        require_few_modes(ElasticLayer.under(known.under_cover(sensor)))
    config_mm = 1e3 * sensor.thickness
    if cover and cover.is_other(config_mm):
        reason = (
            f"is {cover.thickness_mm:g} +- {SURE * cover.thickness_error_mm:.2g}, CONFIG says {config_mm:g}: the "
            "network learns this cover, forces of single taxels are those under CONFIG's"
        )
        warnings.warn(str(InputError(file, "cover.thickness_mm", reason)), Notice, stacklevel=2)
    return known


def _better(file: Path, trained: Trained) -> str | None:
    """Say that the weights in ``file`` are of the same sensor, calibration and word lengths with a smaller error."""
    from tfra.codegen.config.weights import read_weights
    from tfra.train.heldout import QUIET
    from tfra.train.run import CALIBRATION, ROUNDING

    key = f"force_percent_50_at_{QUIET:g}"
    try:
        stored = read_weights(file, trained.sensor, trained.window)
    except InputError:  # no weights, or those of another sensor
        return None
    known = stored.held_out
    same = all(stored.prior.get(fact) == trained.prior.get(fact) for fact in (CALIBRATION, ROUNDING))
    if not same or key not in known or known[key] >= trained.held_out[key]:
        return None
    return f"has better weights, with a held-out error of {known[key]:.1f} % of |F|, not {trained.held_out[key]:.1f} %"


def _table(found: dict[str, float]) -> list[str]:
    """Median and 95th percentile of the held-out errors, a line for each noise, and of a skin for other conditions."""
    from tfra.train.heldout import PERCENTILES, TABLE

    first = next(iter(TABLE))
    lines = []
    for name in (key.removeprefix(f"{first}_{PERCENTILES[0]}_") for key in found if key.startswith(f"{first}_50_")):
        values = (tuple(found[f"{key}_{share}_{name}"] for share in PERCENTILES) for key in TABLE)
        parts = [f"{key} {low:.3g} / {high:.3g}" for key, (low, high) in zip(TABLE, values, strict=True)]
        parts += [f"{kind} {100 * found[key]:.2g} %" for kind in KINDS if (key := f"{kind}_{name}") in found]
        lines.append(f"held-out errors {condition(name)}, median / 95 %: {', '.join(parts)}")
    return lines


def condition(name: str) -> str:
    """The end of a key of held-out errors, in words."""
    kind, *values = name.split("_")
    match kind, values:
        case "at", [level]:
            return f"at {100 * float(level):g} % noise"
        case "gap", [low, high]:
            return f"with a gap of {low} pitches or more" if high == "inf" else f"with a gap of {low} to {high} pitches"
        case "ratio", [ratio]:
            return f"with forces up to 1:{ratio}"
    return {"alone": "of a single contact", "inside": "of windows inside", "edge": "of windows over an edge"}[kind]


@contextmanager
def _progress(stage: str, pieces: int, there: int) -> Iterator[Advance]:
    """Show a stage with the time left, and the last error of the validation set."""
    with progress(stage, pieces - there) as advance:

        def count(pieces: int, state: State | None = None) -> None:
            shown = state.curve[-1] if state and state.curve else None
            title = f"{stage} (validation |dF|/|F| {100 * shown[2]:.1f} %)" if shown else stage
            advance(pieces, title=title)

        yield count
