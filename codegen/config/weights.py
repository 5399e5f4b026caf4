"""WEIGHTS.npz: the learned estimator of one sensor, as ``tfra train`` makes it.

    first, second, read2, read1, direct   float32, as in :class:`tfra.model.learned.network.Weights`
    curve (k, 3)                          step, loss in training, loss on held-out frames
    about                                 JSON: :class:`About`

The archive is sealed as all outputs are, so one that has changed is refused.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, JsonValue, ValidationError

from tfra.codegen.config.complaints import complaint
from tfra.codegen.config.schema import Section, SensorSection
from tfra.codegen.config.write import sensor_section
from tfra.model.arrays import Floats
from tfra.model.learned.network import NAMES, Weights
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import Archive, archive
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.outputs import write_npz
from tfra.runtime.ownership import file_objection

COMMAND = "train"
"""The command that writes such files."""

FORMAT = 2
"""Version of the file's content."""

_AGAIN = "run tfra train again"


@dataclass(frozen=True, eq=False)
class Trained:
    """Weights, and what is known of them.

    ``threshold``: the uncertainty over the normal force above which a frame is implausible.  ``prior``: the
    distribution of the frames of the training, in plain JSON types.  ``held_out``: errors on other frames, by names
    with units.  ``curve (k, 3)``: step, loss in training, loss on held-out frames.  ``window``: for the windows of a
    skin, not for a whole array.
    """

    sensor: SensorArray
    weights: Weights
    threshold: float
    prior: Mapping[str, JsonValue] = field(default_factory=dict)
    held_out: Mapping[str, float] = field(default_factory=dict)
    curve: Floats = field(default_factory=lambda: np.empty((0, 3)))
    window: bool = False


class About(Section):
    """What the file says of the weights."""

    format: int
    generator: str
    sensor: SensorSection
    sensor_sha256: str
    threshold: Annotated[float, Field(gt=0)]
    prior: dict[str, JsonValue]
    held_out: dict[str, float]
    window: bool = False


def sensor_sha256(sensor: SensorArray) -> str:
    """Return the hash of the geometry: equal for equal sensors alone."""
    return hashlib.sha256(json.dumps(sensor_section(sensor), sort_keys=True).encode()).hexdigest()


def write_weights(path: str | Path, trained: Trained) -> None:
    """Write WEIGHTS.npz; equal content gives equal bytes.  Weights are rounded to float32.

    ``path`` and errors as for ``write_npz``.  Raises ``ValueError`` for values that such a file must not hold.
    """
    about = About(
        format=FORMAT,
        generator=f"tfra {version('tfra')}",
        sensor=SensorSection.model_validate(sensor_section(trained.sensor)),
        sensor_sha256=sensor_sha256(trained.sensor),
        threshold=trained.threshold,
        prior=dict(trained.prior),
        held_out=dict(trained.held_out),
        window=trained.window,
    )
    text = json.dumps(about.model_dump(exclude_defaults=True), indent=1, allow_nan=False)
    arrays = {name: getattr(trained.weights, name).astype(np.float32) for name in NAMES}
    write_npz(path, arrays | {"curve": trained.curve, "about": np.array(text)}, COMMAND)


def read_weights(file: Path, sensor: SensorArray, window: bool = False) -> Trained:
    """Read WEIGHTS.npz for ``sensor``, which is a whole array or the ``window`` of a skin.

    Raises ``InputError`` for a file that can't be read, is damaged, of another version, or for another sensor.
    """
    with archive(file) as stored:
        if reason := file_objection(file, COMMAND):
            raise InputError(file, "", f"is no file of tfra {COMMAND}: {reason}: {_AGAIN}")
        missing = next((key for key in (*NAMES, "curve", "about") if key not in stored.keys), None)
        if missing:
            raise InputError(file, missing, f"the key is missing: {_AGAIN}")
        about = _about(stored)
        if about.window != window:
            kinds = ("whole arrays", "windows of a skin")
            reason = f"is trained for {kinds[about.window]}, CONFIG needs those for {kinds[window]}: {_AGAIN}"
            raise InputError(file, "window", reason)
        _require_sensor(file, about, sensor)
        arrays = {key: np.asarray(stored.read(key), dtype=np.float64) for key in (*NAMES, "curve")}
    curve = arrays.pop("curve")
    if curve.ndim != 2 or curve.shape[1] != 3 or not np.isfinite(curve).all():
        raise InputError(file, "curve", f"finite numbers of shape (k, 3) are needed, got shape {curve.shape}")
    try:
        weights = Weights(**arrays)
    except ValueError as error:
        raise InputError(file, "", str(error)) from None
    if weights.taxels != sensor.taxels:
        raise InputError(file, "first", f"{sensor.taxels} taxels are needed, got {weights.taxels}")
    return Trained(sensor, weights, about.threshold, about.prior, about.held_out, curve, window)


def _about(stored: Archive) -> About:
    try:
        content = json.loads(stored.text("about"))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(stored.file, "about", f"is no JSON: {_AGAIN}") from None
    given = content.get("format") if isinstance(content, dict) else None
    if given != FORMAT:
        raise InputError(stored.file, "about.format", f"version {FORMAT} is needed, got {quoted(given)}: {_AGAIN}")
    try:
        return About.model_validate(content)
    except ValidationError as error:
        key, reason = complaint(error, About)
        raise InputError(stored.file, f"about.{key}", reason) from None


def _require_sensor(file: Path, about: About, sensor: SensorArray) -> None:
    """Raise ``InputError`` that names the first difference of the sensors."""
    own = about.sensor.model_dump()
    for key, needed in sensor_section(sensor).items():
        if own[key] != needed:
            trained = f"{own[key]:g}" if isinstance(own[key], float) else quoted(own[key])
            raise InputError(file, f"sensor.{key}", f"is trained for {trained}, CONFIG has {needed:g}: {_AGAIN}")
    if about.sensor_sha256 != sensor_sha256(sensor):
        raise InputError(file, "about.sensor_sha256", f"is not that of the sensor: {_AGAIN}")
