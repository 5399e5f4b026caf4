"""``tfra train``: the learned estimator of a sensor."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tfra.cli.common import Config, Json, Seed, WorkFolder, failures, print_json, progress
from tfra.cli.messages import print_error
from tfra.runtime.errors import InputError, require

if TYPE_CHECKING:
    from tfra.codegen.config.weights import Trained
    from tfra.train.loop import State
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
    work: WorkFolder = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Train the learned estimator of CONFIG's sensor on simulated contacts, and tell its errors on other ones.

    Of a skin it is that of a window: the same weights serve every skin with this pitch, cover and window.  Better
    weights of the same sensor are kept, and the new ones written beside them.
    """
    require("tfra train", "train", "threadpoolctl")
    if minutes is not None and steps is not None:
        raise InputError("tfra train", "--minutes", "and --steps exclude each other")
    from tfra.codegen.config.read import load_tfra
    from tfra.codegen.config.weights import write_weights
    from tfra.runtime.outputs import check_file
    from tfra.train.loop import DivergedError
    from tfra.train.run import Budget, run

    project = load_tfra(config)
    window = project.skin is not None
    units = channels or ((96, 48) if window else (48, 24))
    budget = Budget(units, seed, steps, minutes, window)
    check_file(out, ".npz", "train", [config])
    with failures("train", DivergedError, hint=": another --seed may help"):
        trained = run(project.design.sensor, budget, work or Path(f"{out}.work"), _progress)
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


def _better(file: Path, trained: Trained) -> str | None:
    """Say that the weights in ``file`` are of the same sensor and have a smaller error, if they have."""
    from tfra.codegen.config.weights import read_weights
    from tfra.train.heldout import QUIET

    key = f"force_percent_50_at_{QUIET:g}"
    try:
        known = read_weights(file, trained.sensor, trained.window).held_out
    except InputError:  # no weights, or those of another sensor
        return None
    if key not in known or known[key] >= trained.held_out[key]:
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
