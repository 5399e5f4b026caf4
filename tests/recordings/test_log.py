"""Frames in the logs of robots, written by the libraries of MCAP and rosbag2."""

import struct
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

from tests.recordings.test_formats import FRAMES as DOUBLES
from tests.recordings.test_formats import read, refusal
from tfra.recordings.input import Input

FRAMES = DOUBLES.astype(np.float32)
START = 1_700_000_000_123_456_789
TIMES = [START, START + 1, START + 10_000_000, START + 2_000_000_000]
SECONDS = [0.0, 1e-9, 0.01, 2.0]

STORE = get_typestore(Stores.ROS2_HUMBLE)
ARRAY, IMAGE, TEXT = "std_msgs/msg/Float32MultiArray", "sensor_msgs/msg/Image", "std_msgs/msg/String"

Message = tuple[str, str, int, bytes]
"""Topic, kind, time and content."""


def array(values: np.ndarray) -> bytes:
    layout = STORE.types["std_msgs/msg/MultiArrayLayout"]([], 0)
    return bytes(STORE.serialize_cdr(STORE.types[ARRAY](layout, values.ravel().astype(np.float32)), ARRAY))


def numbers(values: np.ndarray, name: str) -> bytes:
    """An array of numbers of another kind."""
    kind, layout = f"std_msgs/msg/{name}MultiArray", STORE.types["std_msgs/msg/MultiArrayLayout"]([], 0)
    return bytes(STORE.serialize_cdr(STORE.types[kind](layout, values.ravel().astype(name.lower())), kind))


def by_hand(values: np.ndarray) -> bytes:
    """The same, written as the standard of CDR has it: no dimensions, no offset, the count, the numbers."""
    return b"\0\1\0\0" + struct.pack(f"<III{values.size}f", 0, 0, values.size, *values.ravel())


def image(
    values: np.ndarray, encoding: str = "32FC1", padding: int = 0, order: str = "<", number: str = "f4"
) -> bytes:
    rows, columns = values.shape
    size = np.dtype(number).itemsize
    header = STORE.types["std_msgs/msg/Header"](STORE.types["builtin_interfaces/msg/Time"](0, 0), "skin")
    lines = np.ascontiguousarray(values, dtype=f"{order}{number}").view(np.uint8).reshape(rows, size * columns)
    data = np.pad(lines, ((0, 0), (0, padding))).ravel()
    step = size * columns + padding
    content = STORE.types[IMAGE](header, rows, columns, encoding, int(order == ">"), step, data)
    return bytes(STORE.serialize_cdr(content, IMAGE))


def mcap(path: Path, messages: Sequence[Message], encoding: str = "cdr", packed: bool = True) -> Path:
    with open(path, "wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD if packed else CompressionType.NONE)
        writer.start()
        channels: dict[str, int] = {}
        for topic, kind, time, data in messages:
            if topic not in channels:
                schema = writer.register_schema(kind, "ros2msg", b"")
                channels[topic] = writer.register_channel(topic, encoding, schema)
            writer.add_message(channels[topic], log_time=time, data=data, publish_time=0)
        writer.finish()
    return path


def bag(path: Path, messages: Sequence[Message], storage: StoragePlugin) -> Path:
    with BagWriter(path, version=9, storage_plugin=storage) as writer:
        found: dict[str, Any] = {}
        for topic, kind, time, data in messages:
            if topic not in found:
                found[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(found[topic], time, data)
    return path


LOGS: dict[str, Callable[[Path, Sequence[Message]], Path]] = {
    "mcap": lambda folder, messages: mcap(folder / "log.mcap", messages),
    "rosbag2 in SQLite": lambda folder, messages: bag(folder / "log", messages, StoragePlugin.SQLITE3),
    "rosbag2 in MCAP": lambda folder, messages: bag(folder / "log", messages, StoragePlugin.MCAP),
}


def of(topic: str, kind: str, write: Callable[[np.ndarray], bytes], frames: np.ndarray = FRAMES) -> list[Message]:
    return [(topic, kind, time, write(frame)) for time, frame in zip(TIMES, frames, strict=False)]


@pytest.mark.parametrize("log", LOGS.values(), ids=LOGS)
@pytest.mark.parametrize(
    ("kind", "write"),
    [
        (ARRAY, array),
        (ARRAY, by_hand),
        (IMAGE, image),
        (IMAGE, lambda frame: image(frame, padding=5)),
        (IMAGE, lambda frame: image(frame, order=">")),
    ],
)
def test_logs(tmp_path: Path, log: Any, kind: str, write: Any) -> None:
    others = [("/note", TEXT, START + 5, b"\0\1\0\0\1\0\0\0\0"), *of("/arm", ARRAY, lambda frame: array(frame[:1]))]
    found = read(log(tmp_path, sorted([*of("/skin", kind, write), *others], key=lambda message: message[2])))
    np.testing.assert_array_equal(found.frames, FRAMES)
    assert found.time is not None
    assert found.time.tolist() == SECONDS
    assert found.seconds


WORDS = np.random.default_rng(4).integers(0, 100, (4, 2, 3))


@pytest.mark.parametrize("name", ["Float64", "UInt8", "UInt16", "UInt32", "Int8", "Int16", "Int32"])
def test_arrays_of_any_numbers(tmp_path: Path, name: str) -> None:
    words = WORDS - (50 if name.startswith("I") else 0)
    kind = f"std_msgs/msg/{name}MultiArray"
    path = mcap(tmp_path / "f.mcap", of("/a", kind, lambda frame: numbers(frame, name), words))
    assert read(path).frames.tolist() == words.tolist()


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize(
    ("encoding", "number"),
    [
        *(("64FC1", "f8"), ("8UC1", "u1"), ("mono8", "u1"), ("8SC1", "i1"), ("16UC1", "u2"), ("mono16", "u2")),
        *(("16SC1", "i2"), ("32SC1", "i4")),
    ],
)
def test_images_of_one_channel(tmp_path: Path, encoding: str, number: str, order: str) -> None:
    def written(frame: np.ndarray) -> bytes:
        return image(frame, encoding, padding=3, order=order, number=number)

    scale = 1 if number.endswith("1") else 300
    words = scale * (WORDS - (50 if number.startswith("i") else 0))
    assert read(mcap(tmp_path / "f.mcap", of("/a", IMAGE, written, words))).frames.tolist() == words.tolist()


def test_keys_apply(tmp_path: Path) -> None:
    path = mcap(tmp_path / "f.mcap", of("/a", IMAGE, lambda frame: image(frame.T)))
    how = Input(order="columns", unit="kPa", compression="positive")
    np.testing.assert_array_equal(read(path, how).frames, -1000 * FRAMES.astype(np.float64))
    path = mcap(tmp_path / "g.mcap", of("/a", ARRAY, lambda frame: array(np.append([9, 8], frame))))
    found = read(path, Input(skip_columns=2))
    np.testing.assert_array_equal(found.frames, FRAMES)
    assert found.time is not None
    assert found.time.tolist() == SECONDS


def test_topics(tmp_path: Path) -> None:
    path = mcap(tmp_path / "f.mcap", of("/left", ARRAY, array) + of("/right", IMAGE, image, -FRAMES))
    assert refusal(path) == "frames: several topics hold frames, which one? (--topic): /left, /right"
    np.testing.assert_array_equal(read(path, Input(topic="/right")).frames, -FRAMES)
    assert refusal(path, Input(topic="/up")).startswith("frames: the log has no topic '/up' (a Multi")


def test_wrong_logs(tmp_path: Path) -> None:
    path = tmp_path / "f.mcap"
    needed = "a MultiArray of numbers, or an Image with one channel"
    none = f"frames: the log has no topic that holds frames ({needed}), its topics: "
    assert refusal(mcap(path, [])) == f"{none}none"
    assert refusal(mcap(path, of("/a", ARRAY, array), "json")) == f"{none}/a"
    asked = Input(topic="/a")
    assert refusal(path, asked) == f"frames: '/a': {needed} is needed, got 'json'"
    camera = of("/a", IMAGE, lambda frame: image(frame, "rgb8"))
    assert refusal(mcap(path, camera), asked).startswith("frames: '/a': encoding 32FC1, 64FC1, 8UC1, ")
    assert refusal(path, asked).endswith(" is needed, got 'rgb8'")
    other = of("/a", ARRAY, lambda frame: array(np.append(0, frame)))
    assert refusal(mcap(path, other), asked).endswith("is the first column a time stamp? (--skip-columns 1)")
    mixed = [*of("/a", ARRAY, array), ("/a", ARRAY, TIMES[-1] + 1, array(FRAMES[0, 0]))]
    assert refusal(mcap(path, mixed)).startswith("frames: message 4 of '/a': shape (n, 2, 3) or (n, 6) is needed, got ")
    assert refusal(mcap(path, [("/a", IMAGE, 0, image(FRAMES[0])[:-9])])).startswith("frames: a message of '/a' is dam")
    nan = mcap(path, of("/a", ARRAY, lambda frame: array(frame * np.float32("nan"))))
    assert refusal(nan) == "frames: frame 0, row 0, column 0 is not finite"
    good = mcap(path, of("/a", ARRAY, array)).read_bytes()
    path.write_bytes(good[: len(good) // 2])
    assert refusal(path).startswith("is not a readable log: ")
    assert refusal(tmp_path / "none.mcap") == "cannot be read: No such file or directory"
    (tmp_path / "folder").mkdir()
    assert refusal(tmp_path / "folder").endswith("is needed, or the folder of a rosbag2")
    (tmp_path / "folder" / "metadata.yaml").write_text("a: [")
    assert refusal(tmp_path / "folder").startswith("is not a readable log: ")


@pytest.mark.parametrize(("package", "suffix"), [("mcap", "mcap"), ("rosbags", "mcap"), ("polars", "parquet")])
def test_a_missing_package_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package: str, suffix: str) -> None:
    path = tmp_path / f"f.{suffix}"
    path.write_bytes(b"")
    monkeypatch.setattr("tfra.runtime.errors.find_spec", lambda name: None if name == package else find_spec(name))
    extra = "tables" if package == "polars" else "robot"
    assert refusal(path) == f"{package} is missing, please run: pip install 'tfra[{extra}]'"


def test_a_damaged_number_is_noticed(tmp_path: Path) -> None:
    path = mcap(tmp_path / "f.mcap", of("/a", ARRAY, array), packed=False)
    good = path.read_bytes()
    at = good.index(np.float32(FRAMES[2, 0, 0]).tobytes())
    path.write_bytes(good[:at] + b"\1" + good[at + 1 :])
    assert refusal(path).startswith("is not a readable log: crc validation failed")


def test_a_bag_that_names_no_possible_file(tmp_path: Path) -> None:
    path = bag(tmp_path / "log", of("/a", ARRAY, array), StoragePlugin.SQLITE3)
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace("log.db3", f"{'9' * 400}.db3"))
    assert refusal(path) == "cannot be read: File name too long"
