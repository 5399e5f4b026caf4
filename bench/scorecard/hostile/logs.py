"""Readers of recordings: files, logs, streams."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np

from bench.scorecard.hostile.mutate import changed_bytes, of
from bench.scorecard.hostile.reader import Prepared, Read, archives, configured, of_file
from tfra.recordings.formats import parquet
from tfra.recordings.frames import read_recording
from tfra.recordings.input import Input
from tfra.recordings.lines import FrameLines
from tfra.recordings.streams import Stream

HOW = (
    Input(),
    Input(skip_columns=1),
    Input(unit="codes", columns="r{row}c{column}", tare_frames=2),
    Input(unit="kPa", columns="2-13", compression="positive", order="columns"),
    Input(unit="codes", coding="offset", average=2, drift_frames=9, dead=((0, 1),)),
    Input(flip_x=True, flip_y=True, tare_frames=1, strict=True),
)
"""Ways in which recordings are read; an input's length chooses one."""


def recording(folder: Path, name: str) -> Read:
    """A reader of recordings of this ``name``."""
    design = configured(folder).design

    def read(path: Path) -> object:
        given = HOW[path.stat().st_size % len(HOW)]
        given = given if path.suffix == ".csv" else replace(given, columns=None)
        return read_recording(path, design.sensor, design.adc, given)

    return of_file(folder / name, read)


def frames() -> Any:
    """Frames of codes, ``(6, 3, 4)``."""
    return np.random.default_rng(1).integers(-3000, 3000, (6, 3, 4))


def lines() -> list[bytes]:
    """Texts of frames."""
    rows = [[str(code) for code in frame] for frame in frames().reshape(6, 12).tolist()]
    header = ["t", *(f"r{row}c{column}" for row in range(3) for column in range(4))]
    timed = [header, *([f"0.{number}", *row] for number, row in enumerate(rows))]
    comma = [",".join(f"{code}.5" for code in row) for row in rows]
    texts = [
        "\n".join(comma),
        "# a log\n" + "\r\n".join(";".join(row).replace(".", ",") for row in timed),
        "\n".join("\t".join(f'"{cell}"' for cell in row) for row in timed),
        "\n".join(" | ".join(row) for row in rows) + "\n",
    ]
    return [text.encode() for text in texts]


def text(folder: Path) -> Prepared:
    """Recordings as text."""
    return of(lines()), recording(folder, "log.csv")


def npy(folder: Path) -> Prepared:
    """Arrays of NumPy, whose header is text."""
    seeds = []
    for array in (frames().astype(float), frames(), frames().reshape(6, 12).astype("f4"), np.asfortranarray(frames())):
        stream = BytesIO()
        np.save(stream, array)
        seeds.append(stream.getvalue())
    binary, header = of(seeds, changed_bytes), of(seeds)
    return lambda rng: rng.choice((binary, header))(rng), recording(folder, "log.npy")


def npz(folder: Path) -> Prepared:
    """Archives of NumPy."""
    stored = {"frames": frames().astype(float), "time": np.arange(6.0)}
    return archives([stored, {"frames": frames()}]), recording(folder, "log.npz")


def tables(folder: Path) -> Prepared:
    """Parquet files: columns, or one of lists.  What converts them in a process of its own is called in this one."""
    import polars as pl

    @contextmanager
    def converting(command: list[str], place: Path, stdout: int) -> Iterator[Any]:
        code = 0
        try:
            pl.read_parquet(command[3], glob=False).write_ipc(place / command[4])
        except Exception:
            code = 1
        except BaseException as error:  # a panic of polars
            if "Panic" not in type(error).__name__:
                raise
            code = 101
        yield SimpleNamespace(wait=lambda: code)

    vars(parquet)["running"] = converting
    rows = frames().reshape(6, 12).astype(float)
    columns = {f"c{number}": rows[:, number] for number in range(12)}
    seeds = []
    for table in ({"t": np.arange(6.0), **columns}, columns, {"frame": rows.tolist()}, {"frame": frames().tolist()}):
        pl.DataFrame(table).write_parquet(folder / "seed.parquet")
        seeds.append((folder / "seed.parquet").read_bytes())
    kinds = (pl.Int8, pl.Float32, pl.String, pl.Boolean, pl.Date, pl.UInt64)

    def draw(rng: Random) -> bytes:
        if rng.randrange(2):
            return of(seeds, changed_bytes)(rng)
        table = pl.read_parquet(rng.choice(seeds))
        for name in rng.sample(table.columns, min(len(table.columns), rng.randrange(3))):
            column = table[name]
            if rng.randrange(2) and column.dtype.is_numeric():
                table = table.with_columns(column.cast(rng.choice(kinds), strict=False))
            else:
                other = [None, float("nan"), 1e300] if column.dtype.is_numeric() else [None, [], [None]]
                changed = [rng.choice(other), *column.to_list()[1:]]
                table = table.with_columns(pl.Series(name, changed, dtype=column.dtype, strict=False))
        table = rng.choice((table, table, table[:0], table[:, ::-1], table.drop(table.columns[0])))
        stream = BytesIO()
        table.write_parquet(stream)
        return stream.getvalue()

    return draw, recording(folder, "log.parquet")


def messages() -> list[tuple[str, str, bytes]]:
    """Messages of ROS 2: topic, kind, data."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types, image, array = store.types, "sensor_msgs/msg/Image", "std_msgs/msg/Float32MultiArray"
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](0, 0), "skin")
    found = []
    for frame in frames().astype("f4"):
        layout = types["std_msgs/msg/MultiArrayLayout"]([], 0)
        found.append(("/skin", array, bytes(store.serialize_cdr(types[array](layout, frame.ravel()), array))))
        picture = types[image](header, 3, 4, "32FC1", 0, 16, frame.view(np.uint8).ravel())
        found.append(("/image", image, bytes(store.serialize_cdr(picture, image))))
    return found


def mcap(folder: Path) -> Prepared:
    """Logs in MCAP: with changed messages, and with changed bytes."""
    from mcap.writer import CompressionType, Writer

    def log(sent: list[tuple[str, str, bytes]], packing: CompressionType) -> bytes:
        stream = BytesIO()
        writer = Writer(stream, compression=packing)
        writer.start()
        for number, (topic, kind, data) in enumerate(sent):
            schema = writer.register_schema(kind, "ros2msg", b"")
            channel = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channel, log_time=number, data=data, publish_time=0)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap's own has no types
        return stream.getvalue()

    good = messages()
    kinds = (good[::2], good[1::2])
    seeds = [log(sent, packing) for sent in kinds for packing in (CompressionType.NONE, CompressionType.ZSTD)]

    def draw(rng: Random) -> bytes:
        if rng.randrange(2):
            return of(seeds, changed_bytes)(rng)
        return log(changed_message(list(rng.choice(kinds)), rng), CompressionType.NONE)

    return draw, recording(folder, "log.mcap")


def changed_message(sent: list[tuple[str, str, bytes]], rng: Random) -> list[tuple[str, str, bytes]]:
    """Messages, of which one has other data or another kind."""
    at = rng.randrange(len(sent))
    topic, kind, data = sent[at]
    kind = kind if rng.randrange(6) else rng.choice(("std_msgs/msg/Int8MultiArray", "sensor_msgs/msg/Image", "x"))
    sent[at] = (topic, kind, of([data], changed_bytes)(rng))
    return sent


def bag(folder: Path) -> Prepared:
    """Folders of rosbag2: changed metadata, changed bytes of the table, changed messages."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    place, good = folder / "bag", messages()[::2]
    with Writer(place, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topic, kind, _ = good[0]
        connection = writer.add_connection(topic, kind, typestore=get_typestore(Stores.ROS2_HUMBLE))
        for number, (_, _, data) in enumerate(good):
            writer.write(connection, number, data)
    kept = {file.name: file.read_bytes() for file in place.iterdir()}
    (table,) = kept.keys() - {"metadata.yaml"}
    about, stored = of([kept["metadata.yaml"]]), of([kept[table]], changed_bytes)
    design = configured(folder).design

    def draw(rng: Random) -> bytes:
        which = rng.randrange(3)
        if which < 2:
            return bytes([which]) + (about, stored)[which](rng)
        return b"\2" + of([good[0][2]], changed_bytes)(rng)

    def read(data: bytes) -> object:
        for name, content in kept.items():
            (place / name).write_bytes(content)
        if data[0] < 2:
            (place / ("metadata.yaml", table)[data[0]]).write_bytes(data[1:])
        else:
            with closing(sqlite3.connect(place / table)) as connection, connection:
                connection.execute("UPDATE messages SET data = ? WHERE id = 2", (data[1:],))
        return read_recording(place, design.sensor, design.adc, Input())

    return draw, read


def stream(folder: Path) -> Prepared:
    """Lines of a connection or a serial port, which come in pieces."""
    design = configured(folder).design

    def read(data: bytes) -> object:
        size = 1 + len(data) % 200
        pieces = [data[start : start + size] for start in range(0, len(data), size)]
        source = Stream("s", iter([*pieces, b""]).__next__, midway=bool(size % 2))
        taken = FrameLines(design.sensor, design.adc, HOW[len(data) % len(HOW)])
        return sum(not isinstance(each, str) for each in taken.frames(source.lines(), lambda stress: None))

    return of(lines()), read
