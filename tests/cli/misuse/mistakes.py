"""Faulty files of users: each function returns a function that makes one in the current folder."""

import io
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl
from mcap.writer import Writer

from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.runtime.outputs import output_directory

LSB = Adc().lsb
"""Stress of a code, in Pa."""

ROWS, COLUMNS = 5, 6

CONFIG = """\
[sensor]
rows = 5
columns = 6
pitch_x_mm = 4
pitch_y_mm = 4
thickness_mm = 3
[[contact]]
shape = "hertz"
half_x_mm = 5
half_y_mm = 4
force_n = -5
mu = 0.4
phi_deg = [0, 45, 120]
"""

Make = Callable[[], object]
"""Makes files in the current folder."""


@dataclass(frozen=True)
class Misuse:
    """One case: files made, and ``arguments`` that follow ``tfra``, split at blanks.

    ``answers.json`` has what stderr shows: one line, or, with exit ``code`` 0, warnings.
    """

    name: str
    make: Make
    arguments: str
    code: int = 2


def nothing() -> None:
    """Make no file."""


def config(old: str, new: str, file: str = "wrong.toml") -> Make:
    """Make ``file``, CONFIG with ``old`` replaced."""
    assert old in CONFIG
    return lambda: Path(file).write_text(CONFIG.replace(old, new))


def extra(text: str) -> Make:
    """Make ``wrong.toml``, CONFIG with ``text`` behind it."""
    return lambda: Path("wrong.toml").write_text(CONFIG + text)


def raw(file: str, data: bytes) -> Make:
    """Make ``file`` of ``data``."""
    return lambda: Path(file).write_bytes(data)


def array(value: object) -> Make:
    """Make ``wrong.npy``."""
    return lambda: np.save("wrong.npy", np.asarray(value))


def header(shape: str, kind: str = "'<f8'", version: int = 1) -> Make:
    """Make ``wrong.npy`` of 240 bytes with a header that says something else."""
    text = f"{{'descr': {kind}, 'fortran_order': False, 'shape': {shape}}}\n".encode()
    return raw("wrong.npy", b"\x93NUMPY" + bytes([version, 0]) + struct.pack("<H", len(text)) + text + bytes(240))


def member(change: Callable[[bytearray], object], method: int = zipfile.ZIP_STORED) -> Make:
    """Make ``wrong.npz``, an archive of good frames with something changed in its bytes."""

    def make() -> None:
        np.save(data := io.BytesIO(), np.arange(90.0).reshape(3, ROWS, COLUMNS))
        with zipfile.ZipFile(packed := io.BytesIO(), "w", method) as archive:
            archive.writestr("frames.npy", data.getvalue())
        change(found := bytearray(packed.getvalue()))
        Path("wrong.npz").write_bytes(found)

    return make


def put(offset: int, value: int) -> Callable[[bytearray], object]:
    """Change a field in the local header and in the central directory."""

    def change(data: bytearray) -> None:
        data[offset] = data[data.index(b"PK\x01\x02") + offset + 2] = value

    return change


def lines(separator: str = ",", first: str = "", point: str = ".", before: str = "", n: int = 3) -> Make:
    """Make ``wrong.csv`` of ``n`` frames; ``before`` is at the start of each line, {} in it is its number."""
    frames = [separator.join(f"{value}{point}5" for value in range(30)) for _ in range(n)]
    text = first + "".join(f"{before.format(number)}{frame}\n" for number, frame in enumerate(frames))
    return raw("wrong.csv", text.encode())


def table(columns: dict[str, list[object]]) -> Make:
    """Make ``wrong.parquet``."""
    return lambda: pl.DataFrame(columns).write_parquet("wrong.parquet")


def log(kind: str, topic: str) -> Make:
    """Make ``wrong.mcap`` of a message that ends early."""

    def make() -> None:
        with open("wrong.mcap", "wb") as stream:
            writer = Writer(stream)
            writer.start()
            schema = writer.register_schema(kind, "ros2msg", b"")
            channel = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channel, log_time=0, data=b"\0\1\0\0\x05", publish_time=0)
            writer.finish()

    return make


def references(**values: object) -> Make:
    """Make ``wrong.npz``, good frames with references."""
    return lambda: np.savez("wrong.npz", frames=np.load("frames.npz")["frames"], **values)


def recorded(change: Callable[[Floats], Floats]) -> Make:
    """Make ``wrong.npy``, the good frames (n, rows, columns) with something done to them."""
    return lambda: np.save("wrong.npy", change(np.load("frames.npz")["frames"]))


def noise(frames: Floats) -> Floats:
    """A sensor at rest: 0.05 % of full scale, rms."""
    return np.random.default_rng(1).normal(0, 5e-4 * Adc().full_scale, (40, ROWS, COLUMNS))


def untared(frames: Floats) -> Floats:
    """The frames after ten without a contact; every taxel has an offset of its own, 3 % of the largest magnitude."""
    offset = 0.03 * np.abs(frames).max() * np.random.default_rng(1).uniform(-1, 1, (ROWS, COLUMNS))
    return offset + np.concatenate([np.zeros((10, ROWS, COLUMNS)), frames])


def stuck(frames: Floats) -> Floats:
    """Ten loads of the first frame, and one taxel that does not move."""
    loads = np.linspace(0.2, 1, 10)[:, None, None] * frames[0]
    loads[:, 2, 3] = frames[0, 2, 3]
    return loads


def written(command: str, change: Callable[[Path], object]) -> Make:
    """Make ``core``, an output of ``command`` with something done to it."""

    def make() -> None:
        with output_directory("core", command) as fresh:
            (fresh / "core.v").write_text("module core; endmodule")
        change(Path("core"))

    return make


def folder(name: str, **texts: str) -> Make:
    """Make a folder of files."""

    def make() -> None:
        Path(name).mkdir()
        for stem, text in texts.items():
            Path(name, stem.replace("_", ".")).write_text(text)

    return make


def garble(data: bytearray) -> None:
    """Damage what is packed."""
    data[60:66] = b"\xff" * 6
