"""Checks whether this program wrote an output and whether it is unchanged.

A directory holds a manifest with the hash of every file; an archive (.npz), waves (.vcd), a page (.html) and a CONFIG
(.toml) a seal after the last byte.  Only files that match them are ever replaced or removed; all others are the user's.
"""

import hashlib
import json
import os
import re
import struct
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import BinaryIO

MANIFEST = "tfra-manifest.json"

_COUNT = struct.Struct("<H")
"""The last field of a zip archive: the length of the comment that follows."""

_COMMENTS = {".vcd": (b"$comment ", b" $end\n"), ".html": (b"<!-- ", b" -->\n"), ".toml": (b"# ", b"\n")}
"""What begins and ends a comment in a text file, by the suffix of its name."""

_SEAL = rb"tfra \S+ ([a-z-]+) sha256:([0-9a-f]{64})"
"""A seal says which command wrote the file, and the hash of everything before the seal."""

_ARCHIVE_SEAL = re.compile(rb"(?s).." + _SEAL + rb"\Z")

_TEXT_SEALS = [re.compile(re.escape(begin) + _SEAL + re.escape(end) + rb"\Z") for begin, end in _COMMENTS.values()]

_SEAL_LONGEST = 256
"""Bytes at the end of a file in which its seal is looked for."""

_CHUNK = 1 << 20


def seal_directory(directory: Path, command: str) -> None:
    """Write the manifest of all files that ``command`` has written to ``directory``."""
    files = {name: _digest(directory / name) for name, folder in _entries(directory) if not folder}
    content = {"generator": f"tfra {version('tfra')}", "command": command, "sha256": files}
    (directory / MANIFEST).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def seal_file(path: Path, command: str, suffix: str) -> None:
    """Append to the .npz, .vcd, .html or .toml file at ``path`` a comment with the hash of everything before it."""
    with open(path, "r+b") as stream:
        length = stream.seek(0, os.SEEK_END) - (_COUNT.size if suffix == ".npz" else 0)
        seal = f"tfra {version('tfra')} {command} sha256:{_digest_of(stream, length)}".encode()
        begin, end = _COMMENTS.get(suffix, (_COUNT.pack(len(seal)), b""))
        stream.seek(length)
        stream.write(begin + seal + end)


def directory_objection(directory: Path, command: str | None = None) -> str | None:
    """Return why ``directory`` must not be replaced; None if it is empty, or as ``command`` (None: any) wrote it.

    Raises ``OSError`` when that can't be read.
    """
    if directory.is_symlink() or not directory.is_dir():
        return "it is not a directory"
    if not any(directory.iterdir()):
        return None
    manifest = _manifest(directory)
    if manifest is None:
        first = min(path.name for path in directory.iterdir())
        return f"it holds {first}, and no {MANIFEST} that says tfra wrote it"
    writer, files = manifest
    if command not in (None, writer):
        return f"tfra {writer} wrote it, not tfra {command}"
    return _difference(directory, files)


def file_objection(file: Path, command: str | None = None) -> str | None:
    """The same for an archive, waves, a page or a CONFIG."""
    if not _is_regular(file):
        return "it is not a regular file"
    with open(file, "rb") as stream:
        length = stream.seek(0, os.SEEK_END)
        if not length:
            return None
        stream.seek(max(0, length - _SEAL_LONGEST))
        tail = stream.read()
        zipped = _ARCHIVE_SEAL.search(tail)
        seal = next(filter(None, (zipped, *(text.search(tail) for text in _TEXT_SEALS))), None)
        if not seal:
            return "tfra did not write it"
        if command not in (None, seal[1].decode()):
            return f"tfra {seal[1].decode()} wrote it, not tfra {command}"
        counted = not zipped or _COUNT.unpack_from(seal[0])[0] == len(seal[0]) - _COUNT.size
        unchanged = counted and _digest_of(stream, length - len(seal[0])) == seal[2].decode()
    return None if unchanged else "it has changed since tfra wrote it"


def is_as_written(file: Path, command: str) -> bool:
    """Whether ``file`` is an output of ``command``, as it wrote it."""
    try:
        return file.stat().st_size > 0 and file_objection(file, command) is None
    except (OSError, ValueError):  # the latter for a name with a NUL
        return False


def discard(place: Path) -> bool:
    """Remove this program's files at ``place`` and empty ones; True if nothing is left."""
    if not os.path.lexists(place):
        return True
    if place.is_dir() and not place.is_symlink():
        _discard_directory(place)
    elif file_objection(place) is None:
        place.unlink()
    return not os.path.lexists(place)


def _discard_directory(directory: Path) -> None:
    """Remove the files of the manifest that are as they were, then the manifest, then empty directories."""
    if manifest := _manifest(directory):
        for name, digest in manifest[1].items():
            if _is_regular(file := directory / name) and _digest(file) == digest:
                file.unlink()
        if [name for name, folder in _entries(directory) if not folder] == [MANIFEST]:
            (directory / MANIFEST).unlink()
    for root, _, _ in os.walk(directory, topdown=False):
        if not os.listdir(root):
            os.rmdir(root)


def _difference(directory: Path, files: dict[str, str]) -> str | None:
    """Return the first difference of ``directory`` from the manifest's ``files``; missing files do not matter."""
    folders = {str(parent) for name in files for parent in Path(name).parents}
    for name, folder in _entries(directory):
        if name in folders if folder else name == MANIFEST and _is_regular(directory / name):
            continue
        if folder or name not in files or not _is_regular(directory / name):
            return f"it holds {name}, which tfra did not write"
        if _digest(directory / name) != files[name]:
            return f"{name} in it has changed since tfra wrote it"
    return None


def _manifest(directory: Path) -> tuple[str, dict[str, str]] | None:
    """Return the command that wrote ``directory`` and the SHA-256 of its files, by the manifest in it.

    None where there is none that this program could have written.
    """
    if not _is_regular(directory / MANIFEST):
        return None
    try:
        content = json.loads((directory / MANIFEST).read_bytes())
        generator, command, files = (content[key] for key in ("generator", "command", "sha256"))
        names = all(isinstance(text, str) for pair in files.items() for text in pair)
        inside = all(not {"..", "/"} & set(Path(name).parts) and name != MANIFEST for name in files)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    known = isinstance(generator, str) and generator.startswith("tfra ") and isinstance(command, str)
    return (command, files) if known and names and inside else None


def _entries(directory: Path, below: str = "") -> Iterator[tuple[str, bool]]:
    """Yield the name of everything in ``directory``, relative to it, and whether it is a directory itself."""
    with os.scandir(directory) as found:
        entries = sorted(found, key=lambda entry: entry.name)
    for entry in entries:
        folder = entry.is_dir(follow_symlinks=False)
        yield below + entry.name, folder
        if folder:
            yield from _entries(directory / entry.name, f"{below}{entry.name}/")


def _is_regular(path: Path) -> bool:
    """Whether it is a file; a name that no file can have is none."""
    return os.path.isfile(path) and not os.path.islink(path)


def _digest(file: Path) -> str:
    with open(file, "rb") as stream:
        return _digest_of(stream, os.fstat(stream.fileno()).st_size)


def _digest_of(stream: BinaryIO, length: int) -> str:
    """SHA-256 of the first ``length`` bytes."""
    hashed = hashlib.sha256()
    stream.seek(0)
    while length > 0 and (chunk := stream.read(min(length, _CHUNK))):
        hashed.update(chunk)
        length -= len(chunk)
    return hashed.hexdigest()
