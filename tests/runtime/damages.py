"""Kinds of damage to an entry of a cache."""

import os
import socket
from collections.abc import Callable
from pathlib import Path

from tfra.runtime.scratch import part


def _content(change: Callable[[bytes], bytes]) -> Callable[[Path], None]:
    return lambda entry: entry.write_bytes(change(entry.read_bytes())) and None


def _flipped(place: Callable[[bytes], int]) -> Callable[[Path], None]:
    def change(content: bytes) -> bytes:
        at = place(content)
        return content[:at] + bytes([content[at] ^ 16]) + content[at + 1 :]

    return _content(change)


def _instead(make: Callable[[Path], object]) -> Callable[[Path], None]:
    def damage(entry: Path) -> None:
        entry.unlink()
        make(entry)

    return damage


def _folder(entry: Path) -> None:
    (entry / "obj").mkdir(parents=True)
    (entry / "obj" / "top.v").write_text("module top; endmodule")


def _socket(entry: Path) -> None:
    here = Path.cwd()
    os.chdir(entry.parent)  # names of sockets are short
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(entry.name[:90])
        os.rename(entry.name[:90], entry.name)
    finally:
        os.chdir(here)


def _another(entry: Path) -> None:
    """The intact content of another entry."""
    others = [path for path in entry.parent.iterdir() if path != entry and path.is_file()]
    entry.write_bytes(others[0].read_bytes() if others else entry.read_bytes()[::-1])


def _lock(make: Callable[[Path], object]) -> Callable[[Path], None]:
    return _instead(lambda entry: make(entry.with_name(f".tfra-{entry.name}.lock")))


def _part(make: Callable[[Path], object]) -> Callable[[Path], None]:
    return _instead(lambda entry: make(part(entry.parent, entry.name)))


DAMAGES: dict[str, Callable[[Path], None]] = {
    "missing": _instead(lambda entry: None),
    "empty": _content(lambda content: b""),
    "a few bytes": _content(lambda content: content[:10]),
    "no manifest": _content(lambda content: content[:32]),
    "half": _content(lambda content: content[: len(content) // 2]),
    "last byte cut": _content(lambda content: content[:-1]),
    "a byte more": _content(lambda content: content + b"\0"),
    "a bit of the hash": _flipped(lambda content: 5),
    "a bit of the manifest": _flipped(lambda content: 36),
    "a bit in the middle": _flipped(lambda content: len(content) // 2),
    "the last bit": _flipped(lambda content: len(content) - 1),
    "zeros": _content(lambda content: bytes(len(content))),
    "text": _content(lambda content: b"nothing to see here\n" * 100),
    "another entry": _another,
    "an empty folder": _instead(Path.mkdir),
    "a full folder": _instead(_folder),
    "a locked folder": _instead(lambda entry: (_folder(entry), entry.chmod(0))),
    "a dangling link": _instead(lambda entry: entry.symlink_to("nowhere")),
    "a link to itself": _instead(lambda entry: entry.symlink_to(entry.name)),
    "a link to a device": _instead(lambda entry: entry.symlink_to("/dev/zero")),
    "a pipe": _instead(os.mkfifo),
    "a socket": _instead(_socket),
    "unreadable": _instead(lambda entry: (entry.write_bytes(b""), entry.chmod(0))),
    "a lock that nobody holds": _lock(Path.touch),
    "an unreadable lock": _lock(lambda lock: (lock.touch(), lock.chmod(0))),
    "a folder as lock": _lock(Path.mkdir),
    "a link as lock": _lock(lambda lock: lock.symlink_to("nowhere")),
    "half an entry of a killed run": _part(lambda fresh: fresh.write_bytes(b"half")),
    "a folder of a killed run": _part(_folder),
}
"""Kinds of damage to an entry, by name."""
