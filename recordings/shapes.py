"""Shapes of an array that are read as frames.

    (n, rows, columns), (rows, columns)         frames, a frame; columns come first with ``order = "columns"``
    (n, skip_columns + taxels), (taxels,)       a frame in each row, a frame

No shape is ambiguous: a sensor has at least two rows and two columns, so neither number equals that of the taxels.
"""

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import Array, Shape
from tfra.recordings.format import finite
from tfra.recordings.input import Input
from tfra.runtime.errors import shortened

FRAMES = "frames"
"""The key of the stresses."""


def split(array: Array, sensor: SensorArray, given: Input) -> tuple[Array, Floats | None]:
    """Return the frames of ``array``, ``(n, taxels)`` or ``(n, ...)``, and the times before them, if any.

    Its shape must be one that ``wrong_shape`` accepts.
    """
    if array.shape in (given.shape(sensor), (sensor.taxels,)):
        return array[None], None
    if array.ndim == 3 or not given.skip_columns:
        return array, None
    return array[:, given.skip_columns :], finite(array[:, 0])


def wrong_shape(sensor: SensorArray, given: Input, shape: Shape) -> str | None:
    """Return what is wrong with a ``shape`` that is not one of frames, and what it may be."""
    frame, width, skip = given.shape(sensor), sensor.taxels + given.skip_columns, given.skip_columns
    if shape in (frame, (sensor.taxels,)):
        return None
    if (len(shape) == 3 and shape[1:] == frame) or (len(shape) == 2 and shape[1] == width):
        return None
    other = "columns" if given.order == "rows" else "rows"
    axes, cells = len(shape), shape[1] if len(shape) == 2 else 0
    hints = (
        (shape[-2:] == frame[::-1] and axes in (2, 3), f": is every frame transposed? (--order {other})"),
        (axes == 3 and shape[:2] == frame, ": are frames along the last axis? they must be along the first"),
        (skip and cells == sensor.taxels, ": are all columns taxels? (--skip-columns 0)"),
        (cells == sensor.taxels + 1, ": is the first column a time stamp? (--skip-columns 1)"),
    )
    hint = next((hint for holds, hint in hints if holds), "")
    return f"shape (n, {frame[0]}, {frame[1]}) or (n, {width}) is needed, got {shortened(str(shape))}{hint}"
