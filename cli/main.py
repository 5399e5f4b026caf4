"""The command line.  Exit codes: 0 success, 1 a check failed, 2 bad input, with one line on stderr."""

import sys
import warnings
from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Annotated

import typer

from tfra.cli.calibrate import calibrate
from tfra.cli.estimate import estimate
from tfra.cli.examples import examples
from tfra.cli.frames import frames
from tfra.cli.generate import generate
from tfra.cli.init import init
from tfra.cli.live import live
from tfra.cli.messages import print_error
from tfra.cli.paper import paper
from tfra.cli.size import size
from tfra.cli.study import study
from tfra.cli.synth import synth
from tfra.cli.train import train
from tfra.cli.verify import verify
from tfra.cli.view import view
from tfra.runtime.errors import InputError, Notice, shortened
from tfra.runtime.processes import Stopped, stoppable

EXAMPLES: dict[Callable[..., None], tuple[str, ...]] = {
    init: (
        "tfra init --rows 8 --columns 12 --pitch-x 3 --pitch-y 2.5 --thickness 3 --out sensor.toml",
        "tfra init --rows 8 --columns 12 --pitch-x 3 --pitch-y 2.5 --thickness 3 "
        "--adc-bits 12 --full-scale 150e3 --target ecp5-45 --out sensor.toml",
    ),
    examples: ("tfra examples --out examples", "tfra examples", "tfra examples skin_8x12"),
    frames: ("tfra frames examples/hertz_40x20.toml --out frames.npz",),
    estimate: (
        "tfra estimate examples/hertz_40x20.toml frames.npz --out forces.npz",
        "tfra estimate examples/hertz_40x20.toml frames.npz --engine fixed --out forces.npz --json",
        "tfra estimate sensor.toml recording.csv --compression positive --out forces.npz",
        "tfra estimate sensor.toml recording.txt --unit kPa --skip-columns 1 --tare-frames 50 --out forces.csv",
    ),
    calibrate: ("tfra calibrate sensor.toml day/*.csv --loads loads.csv --out calibration",),
    train: (
        "tfra train examples/hertz_40x20.toml --out weights.npz",
        "tfra train sensor.toml --out weights.npz --minutes 30 --channels 64 32 --seed 7",
    ),
    view: (
        "tfra view forces.npz --out page.html",
        "tfra view float.npz fixed.npz frames.npz --out page.html --frames 0:2000 --every 2",
    ),
    live: (
        "tfra live examples/hertz_40x20.toml frames.npz --rate 50",
        "tfra live sensor.toml serial:/dev/ttyACM0?baud=115200 --unit kPa --tare-frames 50",
        "tfra live sensor.toml tcp://192.168.0.7:5000 --engine fixed --compression positive",
    ),
    generate: ("tfra generate examples/hertz_40x20.toml --out core",),
    verify: (
        "tfra verify examples/hertz_40x20.toml",
        "tfra verify examples/hertz_40x20.toml --frames frames.npz --simulator verilator --seed 7",
    ),
    size: (
        "tfra size examples/hertz_40x20.toml --target ecp5-85 --frames-per-second 20000 --latency-us 100",
        "tfra size examples/hertz_40x20.toml --target ecp5-45 --frames-per-second 1e5 --latency-us 20 --clock-mhz 90",
        "tfra size examples/balanced.toml --target all --frames-per-second 1000 --latency-us 2000 --page parts.html",
        "tfra size examples/balanced.toml --target ice40up5k --frames-per-second 1000 --latency-us 1000 --json",
    ),
    synth: (
        "tfra synth examples/hertz_40x20.toml --target ecp5-85 --out fpga",
        "tfra synth examples/hertz_40x20.toml --target ecp5-85-8 --seeds 5 --clock-mhz 120 --out fpga --json",
    ),
    paper: ("tfra paper --out paper_again",),
    study: (
        "tfra study examples/study_quick.toml --out study",
        "tfra study examples/study_hertz.toml --out study --workers 8",
        "tfra study mine.toml --out study --work /shared/mine.work --scheduler tcp://node1:8786",
    ),
}


def _epilog(title: str, lines: Sequence[str]) -> str:
    return "\n\n".join([f"[bold]{title}[/bold]", *(f"  {line}" for line in lines)])


app = typer.Typer(
    invoke_without_command=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    epilog=_epilog("From a sensor to its core:", [lines[0] for lines in EXAMPLES.values()]),
)
for command, lines in EXAMPLES.items():
    app.command(epilog=_epilog("Examples:", lines))(command)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"tfra {version('tfra')}")
        raise typer.Exit


@app.callback()
def top(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """FPGA cores that compute triaxial contact forces from an array of normal-stress taxels (TFRA algorithm).

    A CONFIG file in TOML describes the sensor, its converter, the arithmetic and, for simulation, contacts.

    tfra init writes a CONFIG file for your sensor, with a comment on every key.
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line (``sys.argv`` by default) and return its exit code."""
    warnings.showwarning = lambda message, *_: print_error(f"warning: {message}")
    warnings.simplefilter("always", Notice)
    try:
        with stoppable():
            return app(arguments, prog_name="tfra", standalone_mode=False) or 0
    except Stopped as stopped:
        return stopped.exit_code
    except InputError as error:
        message = str(error)
    except typer.TyperException as error:
        command = str(getattr(getattr(error, "ctx", None), "command_path", "tfra"))
        message = str(InputError(command, "", error.format_message().replace("Value error, ", "")))
    except MemoryError as error:  # NumPy states how much was needed
        line = " ".join(["tfra", *(sys.argv[1:] if arguments is None else arguments)])
        message = str(InputError(shortened(line, 200), "not enough memory", str(error)))
    print_error(message)
    return 2
