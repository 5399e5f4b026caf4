"""The example CONFIG and STUDY files, the recording and the weights that are installed with the program."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path

from tfra.codegen.files import output_directory


def examples() -> dict[str, str]:
    """The text of every example by its name, without ``.toml``, sorted."""
    found = [file for file in files("tfra.examples").iterdir() if file.name.endswith((".toml", ".csv"))]
    return {file.name.removesuffix(".toml"): file.read_text("utf-8") for file in sorted(found, key=lambda f: f.name)}


def title(text: str) -> str:
    """The first line of an example, which says what it is."""
    return text.partition("\n")[0].removeprefix("# ")


def write_examples(path: Path, names: list[str]) -> list[str]:
    """Write the examples ``names``, the files that they read and their sensors' weights to the directory ``path``.

    Returns the names of the files.  Raises ``InputError`` as ``output_directory``.
    """
    known = examples()
    chosen = {*names, *(_config(known[name]) for name in names if _file(name) != name)} & known.keys()
    weights = [file for name in chosen if (file := files("tfra.examples") / f"{name}.weights.npz").is_file()]
    with output_directory(path, "examples") as folder:
        for name in chosen:
            (folder / _file(name)).write_text(known[name], encoding="utf-8", newline="\n")
        for file in weights:
            (folder / file.name).write_bytes(file.read_bytes())
    return sorted([*map(_file, chosen), *(file.name for file in weights)])


def _file(name: str) -> str:
    """The file of the example ``name``."""
    return name if name.endswith(".csv") else f"{name}.toml"


def _config(text: str) -> str:
    """The example that a STUDY reads, by its name; empty for a CONFIG."""
    return str(tomllib.loads(text).get("config", "")).removesuffix(".toml")
