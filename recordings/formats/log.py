"""Reading a recording from a robot's log: MCAP files, and rosbag2 folders of SQLite or MCAP.

A frame is a message of ROS 2: an array of ``std_msgs`` with a number for each taxel, or ``sensor_msgs/Image`` with one
channel.  Its time is that of the log.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.formats import FRAMES, Format, Values, wrong_shape
from tfra.recordings.input import Input
from tfra.runtime.errors import InputError, quoted, shortened
from tfra.runtime.inputs import opened

_NUMBERS = ("Float32", "Float64", "UInt8", "UInt16", "UInt32", "Int8", "Int16", "Int32")
_ARRAYS = frozenset(f"std_msgs/msg/{name}MultiArray" for name in _NUMBERS)
_IMAGE = "sensor_msgs/msg/Image"

_PIXELS = {
    **{"32FC1": "f4", "64FC1": "f8", "8UC1": "u1", "mono8": "u1", "16UC1": "u2", "mono16": "u2"},
    **{"8SC1": "i1", "16SC1": "i2", "32SC1": "i4"},
}
"""Numbers of a pixel by the encoding."""

_NEEDED = "a MultiArray of numbers, or an Image with one channel"
"""What a topic of frames has."""

_Message = tuple[str, str, int, bytes]
"""The topic, the kind, the time of the log in ns, and the data."""


def read(path: Path, sensor: SensorArray, given: Input) -> Values:
    """Return the frames of one topic, and their times in s since the first of them.

    The topic is ``given.topic``, or the only one whose first message is a frame.  Raises ``InputError`` if there is no
    such topic or another of its messages is no frame, and for damaged logs.
    """
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    frames: dict[str, list[Floats]] = {}
    times: dict[str, list[int]] = {}
    refused: dict[str, str] = {}
    for topic, kind, time, data in _messages(path):
        if topic in refused or given.topic not in (None, topic):
            refused.setdefault(topic, "is not asked for")
            continue
        frame = _frame(path, store, topic, kind, data)
        if reason := frame if isinstance(frame, str) else wrong_shape(sensor, given, (1, *frame.shape)):
            if topic in frames:
                raise InputError(path, FRAMES, f"message {len(frames[topic])} of {quoted(topic)}: {reason}")
            refused[topic] = reason
        else:
            frames.setdefault(topic, []).append(np.asarray(frame))
            times.setdefault(topic, []).append(time)
    topic = _only(path, given, list(frames), refused)
    since, values = np.array(times[topic], dtype=np.int64), np.stack(frames[topic])
    frames_of_topic = values[:, given.skip_columns :] if values.ndim == 2 else values
    return Values(frames_of_topic, (since - since[0]) / 1e9, seconds=True)


def _only(path: Path, given: Input, found: list[str], refused: dict[str, str]) -> str:
    if len(found) == 1:
        return found[0]
    if found:
        names = shortened(", ".join(sorted(found)), 120)
        raise InputError(path, FRAMES, f"several topics hold frames, which one? (--topic): {names}")
    if given.topic is not None and given.topic in refused:
        raise InputError(path, FRAMES, f"{quoted(given.topic)}: {refused[given.topic]}")
    names = shortened(", ".join(sorted(refused)), 120) or "none"
    wanted = f"no topic {quoted(given.topic)}" if given.topic is not None else "no topic that holds frames"
    raise InputError(path, FRAMES, f"the log has {wanted} ({_NEEDED}), its topics: {names}")


def _frame(path: Path, store: Any, topic: str, kind: str, data: bytes) -> Floats | str:
    """The numbers of a message, or why it has none; an image gives its rows."""
    if kind not in (*_ARRAYS, _IMAGE):
        return f"{_NEEDED} is needed, got {quoted(kind)}"
    try:
        content = store.deserialize_cdr(data, kind)
        if kind in _ARRAYS:
            return np.asarray(content.data, dtype=np.float64)
        if content.encoding not in _PIXELS:
            return f"encoding {', '.join(_PIXELS)} is needed, got {quoted(content.encoding)}"
        number = np.dtype(_PIXELS[content.encoding]).newbyteorder(">" if content.is_bigendian else "<")
        lines = np.asarray(content.data, dtype=np.uint8).reshape(content.height, content.step)
        pixels = np.ascontiguousarray(lines[:, : number.itemsize * content.width])
        return pixels.view(number).astype(np.float64)
    except Exception as error:  # a decoder that trusts its input may raise anything
        reason = shortened(str(error), 100)
        raise InputError(path, FRAMES, f"a message of {quoted(topic)} is damaged: {reason}") from None


def _messages(path: Path) -> Iterator[_Message]:
    """Every message of the log in the order of time; raises ``InputError`` where it is damaged."""
    found = _of_bag(path) if path.is_dir() else _of_mcap(path)
    try:
        yield from found
    except (InputError, MemoryError):
        raise
    except OSError as error:
        raise InputError(path, "", f"cannot be read: {error.strerror or error}") from None
    except Exception as error:  # as above
        raise InputError(path, "", f"is not a readable log: {shortened(str(error), 100)}") from None


def _of_bag(path: Path) -> Iterator[_Message]:
    from rosbags.rosbag2 import Reader

    with Reader(path) as reader:
        for connection, time, data in reader.messages():
            yield connection.topic, connection.msgtype, time, data


def _of_mcap(path: Path) -> Iterator[_Message]:
    from mcap.reader import make_reader

    with opened(path) as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            kind = schema.name if schema and channel.message_encoding == "cdr" else channel.message_encoding
            yield channel.topic, kind, message.log_time, message.data


FORMAT = Format((".mcap",), read, marker="metadata.yaml", needs=("robot", "mcap", "rosbags"))
