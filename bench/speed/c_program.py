"""TFRA as a C program: ``bench/c/*.c`` with the constants of a sensor, compiled to a library and called from Python."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bench.publish import ROOT
from tfra.model.arrays import Floats
from tfra.model.boussinesq import operators
from tfra.model.choices import Architecture
from tfra.model.fixed.butterfly import HADAMARD, taxel_index
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import COEFFICIENT_LIMIT, TIE, Result

SOURCES = ROOT / "bench" / "c"

MULTIPLE = 8
"""Rows of vectors are padded to a multiple of this many words, so that loops over them have no remainder."""

@dataclass(frozen=True, slots=True)
class Program:
    """A program to compile: ``source`` is ``tfra`` (folded) or ``literal``, ``real`` is ``double`` or ``float``."""

    source: str
    real: str
    flags: tuple[str, ...] = ("-O3", "-march=native")


class Library:
    """``program`` for ``sensor`` and a sweep of ``steps`` + 1 candidates, compiled in ``directory``; threshold in Pa.

    Raises ``ValueError`` without a C compiler, for an odd number of rows or columns, and with the compiler's words when
    it fails.
    """

    def __init__(
        self, program: Program, sensor: SensorArray, steps: int, directory: Path, contact_threshold: float = 0.0
    ) -> None:
        self.real = np.dtype(np.float64 if program.real == "double" else np.float32)
        self.sensor = sensor
        tables = {"tfra": folded_tables, "literal": literal_tables}[program.source](sensor)
        self._library = ctypes.CDLL(str(_compile(program, header(sensor, steps, contact_threshold, tables), directory)))
        size = ctypes.c_int.in_dll(self._library, "result_size").value
        if size != self._result.itemsize:
            raise ValueError(f"result: {self._result.itemsize} bytes in Python, {size} in C")

    @property
    def _result(self) -> np.dtype[np.void]:
        """``struct result`` of tfra.h."""
        scalars = [(name, self.real) for name in ("phi_deg", "mu", "mu_x", "mu_y")]
        planes = (3, self.sensor.rows, self.sensor.columns)
        fields = [("forces", self.real, planes), ("resultant", self.real, 3), *scalars]
        return np.dtype([*fields, ("sweep_index", np.intc), ("status", np.intc)], align=True)

    def __call__(self, frames: Floats) -> tuple[Result, Floats]:
        """Results of ``frames (n, rows, columns)`` in Pa, and nanoseconds ``(n,)`` for each."""
        stress = np.ascontiguousarray(frames, dtype=self.real)
        results, times = np.zeros(len(stress), self._result), np.zeros(len(stress))
        self._library.measure(ctypes.c_long(len(stress)), *map(_pointer, (stress, results, times)))
        fields: dict[str, Any] = {name: results[name] for name in self._result.names or ()}
        return Result(**fields), times

    def overhead(self, count: int) -> Floats:
        """Nanoseconds ``(count,)`` between two readings of the clock with nothing between them."""
        times = np.zeros(count)
        self._library.overhead(ctypes.c_long(count), _pointer(times))
        return times


def _pointer(array: npt.NDArray[Any]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def compiler() -> str:
    """The C compiler's name and version; raises ``ValueError`` with what to install if there is none."""
    if shutil.which("cc") is None:
        raise ValueError("cc is missing, please run: apt-get install gcc libc6-dev")
    return subprocess.run(["cc", "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]


def _compile(program: Program, constants: str, directory: Path) -> Path:
    compiler()
    (directory / "sensor.h").write_text(constants)
    files = [str(SOURCES / f"{name}.c") for name in (program.source, "measure")]
    library = directory / f"{program.source}.so"
    options = ["-std=c11", "-Wall", "-shared", "-fPIC", f"-DREAL={program.real}", f"-I{directory}"]
    command = ["cc", *program.flags, *options, "-o", str(library), *files, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ValueError(f"cc failed: {done.stderr[-2000:]}")
    return library


def header(sensor: SensorArray, steps: int, threshold: float, tables: dict[str, npt.NDArray[Any]]) -> str:
    """Text of ``sensor.h``: sizes, limits and ``tables``."""
    x, y = sensor.positions()
    constants = {
        "TAXELS": sensor.taxels,
        "STEPS": steps,
        "THRESHOLD": threshold,
        "AREA": sensor.taxel_area,
        "REACH": float(x[-1] + y[-1]),
        "LIMIT": COEFFICIENT_LIMIT,
        "TIE": TIE,
        "DEGREES": math.degrees(1),
        "QUADS": sensor.taxels // 4,
        "PADDED": _padded(sensor),
    }
    lines = [f"#define {name} {_number(value)}" for name, value in constants.items()]
    return "\n".join([*lines, *(_table(name, values) for name, values in tables.items()), ""])


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"((real){value!r})"


def _table(name: str, values: npt.NDArray[Any]) -> str:
    kind = "int" if values.dtype.kind == "i" else "real"
    sizes = "".join(f"[{n}]" for n in values.shape)
    return f"static _Alignas(64) const {kind} {name}{sizes} = {_braces(values.tolist())};"


def _braces(values: Any) -> str:
    return "{" + ",".join(map(_braces, values)) + "}" if isinstance(values, list) else repr(values)


def literal_tables(sensor: SensorArray) -> dict[str, npt.NDArray[Any]]:
    """Positions and whole matrices, by columns."""
    x, y = sensor.positions()
    matrices = {f"FULL_{name.upper()}": matrix.T for name, matrix in vars(operators(sensor)).items()}
    return {"FULL_X": x, "FULL_Y": y, **matrices}


def folded_tables(sensor: SensorArray) -> dict[str, npt.NDArray[Any]]:
    """Operators by operand parity and column, ``(4, Q, padded)``; sums, places and positions of taxels.

    Raises ``ValueError`` for an odd number of rows or columns: quads would share taxels of the middle line.
    """
    if sensor.rows % 2 or sensor.columns % 2:
        raise ValueError(f"rows, columns: even numbers are needed, got {sensor.rows}, {sensor.columns}")
    index = taxel_index(TfraDesign(sensor, architecture=Architecture(4)))
    padded = _padded(sensor)
    ops, first = operators(sensor), index[:, 0]
    matrices = {
        "C33_INV": ops.c33_inv,
        "C33": ops.c33,
        "MINUS_C31": -ops.c31,
        "MINUS_C32": -ops.c32,
        "NORMAL": ops.c33 @ ops.pinv3,
        "PINV1": ops.pinv1,
        "PINV2": ops.pinv2,
        "PINV3": ops.pinv3,
    }
    place = np.empty(sensor.taxels, dtype=np.int64)
    place[index] = np.arange(4) * padded + np.arange(len(index))[:, None]
    # row i of the first mirror taxels; a parity of the operand has the signs of its row of HADAMARD
    tables = {name: _pad((matrix[first][:, index] @ HADAMARD).transpose(2, 1, 0)) for name, matrix in matrices.items()}
    sums = {"SUM1": _pad(ops.pinv1.sum(axis=0)[first]), "SUM2": _pad(ops.pinv2.sum(axis=0)[first])}
    centred = (position - position.mean() for position in sensor.positions())
    positions = {name: _pad(values[index].T).ravel() for name, values in zip("XY", centred, strict=True)}
    return {"PLACE": place, **positions, **sums, **tables}


def _padded(sensor: SensorArray) -> int:
    return -(-sensor.taxels // (4 * MULTIPLE)) * MULTIPLE


def _pad(values: Floats) -> Floats:
    """Zeros after the last axis, up to a multiple of ``MULTIPLE``."""
    short = -values.shape[-1] % MULTIPLE
    return np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, short)])
