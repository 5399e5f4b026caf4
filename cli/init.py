"""``tfra init``: a CONFIG file for a sensor."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tfra.cli.synth import find_target
from tfra.codegen.config.core import check_core
from tfra.model.choices import SERIAL, Adc, Architecture
from tfra.model.sensor import sensor_keys
from tfra.runtime.errors import InputError, Notice

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.families import Target

KEYS = {key.field: key for key in sensor_keys()}
"""Keys of [sensor] by the option that sets them."""

OPTIONS = {
    **{f"sensor.{key.config}": f"--{field.replace('_', '-')}" for field, key in KEYS.items()},
    "adc.bits": "--adc-bits",
    "adc.full_scale_pa": "--full-scale",
}
"""Options of the command, by the keys that they set."""

ADC = Adc()
"""The default converter."""

LENGTHS_MM = 0.05, 100.0
"""Usual pitches and thicknesses; others get a warning."""

FULL_SCALES_PA = 1e3, 1e7
"""Usual full scales: a resting finger presses with some 10 kPa."""


def _option(field: str) -> Any:
    """The option of a key of [sensor]."""
    key = KEYS[field]
    unit = "mm" if key.is_length else key.unit
    return typer.Option(metavar=unit.upper() or "N", help=f"{key.meaning.capitalize()}{unit and f', in {unit}'}.")


Rows = Annotated[int, _option("rows")]
Columns = Annotated[int, _option("columns")]
PitchX = Annotated[float, _option("pitch_x")]
PitchY = Annotated[float, _option("pitch_y")]
Thickness = Annotated[float, _option("thickness")]
Bits = Annotated[int, typer.Option(metavar="N", help="Bits of the converter's signed codes.")]
FullScale = Annotated[float, typer.Option(metavar="PA", help="Stress at the end of the converter's range, in Pa.")]
TargetOption = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="FPGA part of the core, as in tfra synth. Default: any part."),
]
Out = Annotated[Path | None, typer.Option(metavar="CONFIG.toml", help="Output file. Default: standard output.")]


def init(
    rows: Rows,
    columns: Columns,
    pitch_x: PitchX,
    pitch_y: PitchY,
    thickness: Thickness,
    adc_bits: Bits = ADC.bits,
    full_scale: FullScale = ADC.full_scale,
    target: TargetOption = None,
    out: Out = None,
) -> None:
    """Write a CONFIG file for your sensor, with a comment on every key and a contact to simulate."""
    from tfra.codegen.config.write import commented
    from tfra.runtime.outputs import check_file, write_text

    part = target and find_target(target)
    values = {"rows": rows, "columns": columns, "pitch_x": pitch_x, "pitch_y": pitch_y, "thickness": thickness}
    sensor = {KEYS[field].config: value for field, value in values.items()}
    content: dict[str, Any] = {"sensor": sensor, "adc": {"bits": adc_bits, "full_scale_pa": full_scale}}
    if out:
        check_file(out, ".toml", "init")
    project = _project(content | (_core(part) if part else {}), out)
    for doubt in list(_units(project)) or list(_limits(project)):
        warnings.warn(str(doubt), Notice, stacklevel=2)
    text = commented(project.design, project.layer)
    if out:
        write_text(out, text, "init")
        typer.echo(f"{out}: {rows} x {columns} taxels; next: tfra frames {out} --out frames.npz")
    else:
        typer.echo(text, nl=False)


def _core(part: Target) -> dict[str, Any]:
    """The kind of core that ``part`` has enough multipliers for, and the family of its cells."""
    enough = part.available.get("DSP", Architecture().mac_lanes) >= Architecture().mac_lanes
    family = part.family.name if part.family.gateware else "portable"
    return {"target": {"name": family}, "architecture": {"kind": Architecture().kind if enough else SERIAL.kind}}


def _project(content: dict[str, Any], out: Path | None) -> Project:
    """The project of ``content``; raises ``InputError`` that names the option instead of the key."""
    from tfra.codegen.config.names import name_from
    from tfra.codegen.config.read import build_project

    try:
        name = name_from(out.stem) if out else "sensor"
    except ValueError:
        reason = "a core cannot have this name, which Verilog or a port uses: choose another file name"
        raise InputError(out or "", "", reason) from None
    try:
        return build_project({"name": name} | content, Path("tfra init"))
    except InputError as error:
        message = str(error)
        for key, option in OPTIONS.items():
            message = message.replace(f": {key}: ", f": {option}: ")
        raise InputError(message, "", "") from None


def _units(project: Project) -> Iterator[InputError]:
    """Warnings about possible values that were probably given in another unit."""
    sensor, full_scale = project.design.sensor, project.design.adc.full_scale
    low, high = LENGTHS_MM
    for key in (key for key in sensor_keys() if key.is_length):
        length = 1e3 * getattr(sensor, key.field)
        if not low <= length <= high:
            hint = f": was it given in m ({1e3 * length:g} mm)?" if length < low else ": was it given in µm?"
            yield InputError("tfra init", OPTIONS[f"sensor.{key.config}"], f"{length:g} mm is unusual{hint}")
    low, high = FULL_SCALES_PA
    if not low <= full_scale <= high:
        hint = f": was it given in kPa ({1e3 * full_scale:g} Pa)?" if full_scale < low else ": is it in Pa?"
        yield InputError("tfra init", OPTIONS["adc.full_scale_pa"], f"{full_scale:g} Pa is unusual{hint}")


def _limits(project: Project) -> Iterator[InputError]:
    """Why no core can be made for the sensor, while the float engine works."""
    try:
        check_core(project)
    except InputError as error:
        reason = str(error).removeprefix("tfra init: ")
        yield InputError("tfra init", "", f"only the float engine supports this sensor: {reason}")
