"""``tfra train``: the learned estimator of a sensor."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tfra.cli.common import Config, Json, Seed, WorkFolder, failures, print_json, progress
from tfra.runtime.errors import InputError, require

if TYPE_CHECKING:
    from tfra.train.loop import State
    from tfra.train.run import Advance

Out = Annotated[Path, typer.Option(metavar="WEIGHTS.npz", help="Where the weights go.")]
Minutes = Annotated[
    float | None, typer.Option(min=0.01, max=1e5, metavar="M", help="Time of the training itself, instead of --steps.")
]
Steps = Annotated[
    int | None, typer.Option(min=1, max=10**9, metavar="N", help="Steps of 512 frames; default: 120,000.")
]
Channels = Annotated[
    tuple[int, int], typer.Option(min=1, max=1024, metavar="C1 C2", help="Units in each layer, times four mirrors.")
]


def train(
    config: Config,
    out: Out,
    minutes: Minutes = None,
    steps: Steps = None,
    seed: Seed = 1,
    channels: Channels = (48, 24),
    work: WorkFolder = None,
    json: Json = False,
) -> None:
    """Train the learned estimator of CONFIG's sensor on simulated contacts, and tell its errors on other ones."""
    require("tfra train", "train", "threadpoolctl")
    if minutes is not None and steps is not None:
        raise InputError("tfra train", "--minutes", "and --steps exclude each other")
    from tfra.codegen.config.read import load_tfra
    from tfra.codegen.config.weights import write_weights
    from tfra.runtime.outputs import check_file
    from tfra.train.loop import DivergedError
    from tfra.train.run import Budget, run

    sensor = load_tfra(config).design.sensor
    check_file(out, ".npz", "train", [config])
    with failures("train", DivergedError, hint=": another --seed may help"):
        trained = run(sensor, Budget(channels, seed, steps, minutes), work or Path(f"{out}.work"), _progress)
    write_weights(out, trained)
    if json:
        print_json({"out": str(out), "threshold": trained.threshold, "held_out": dict(trained.held_out)})
        return
    for line in _table(dict(trained.held_out)):
        typer.echo(line)
    typer.echo(f"{out}: {channels[0]}/{channels[1]} units, {trained.prior['training.steps']:,} steps")


def _table(found: dict[str, float]) -> list[str]:
    """Median and 95th percentile of the held-out errors, a line for each noise."""
    from tfra.train.run import NOISES, PERCENTILES, TABLE

    lines = []
    for level in NOISES:
        values = (tuple(found[f"{key}_{share}_at_{level:g}"] for share in PERCENTILES) for key in TABLE)
        parts = (f"{key} {low:.3g} / {high:.3g}" for key, (low, high) in zip(TABLE, values, strict=True))
        lines.append(f"held-out errors at {100 * level:g} % noise, median / 95 %: {', '.join(parts)}")
    return lines


@contextmanager
def _progress(stage: str, pieces: int, there: int) -> Iterator[Advance]:
    """Show a stage with the time left, and the last error of the validation set."""
    with progress(stage, pieces - there) as advance:

        def count(pieces: int, state: State | None = None) -> None:
            shown = state.curve[-1] if state and state.curve else None
            title = f"{stage} (validation |dF|/|F| {100 * shown[2]:.1f} %)" if shown else stage
            advance(pieces, title=title)

        yield count
