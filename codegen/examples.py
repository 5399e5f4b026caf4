"""The example CONFIG and STUDY files and the recording that are installed with the program."""

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
    """Write the examples ``names``, and those that they read, to the directory ``path``; returns their files' names.

    Raises ``InputError`` as ``output_directory``.
    """
    known = examples()
    studies = [name for name in names if not name.endswith(".csv")]
    read = {str(tomllib.loads(known[name]).get("config", "")).removesuffix(".toml") for name in studies}
    chosen = {name if name.endswith(".csv") else f"{name}.toml": known[name] for name in {*names, *read} & known.keys()}
    with output_directory(path, "examples") as folder:
        for file, text in chosen.items():
            (folder / file).write_text(text, encoding="utf-8", newline="\n")
    return sorted(chosen)
