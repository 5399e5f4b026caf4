"""The example CONFIG and STUDY files, the recording and the weights that are installed with the program."""

import tomllib
from importlib.resources import files
from pathlib import Path

from tfra.runtime.outputs import output_directory


def examples() -> dict[str, str]:
    """The text of every example by its name, without ``.toml``, sorted."""
    entries = [file for file in files("tfra.examples").iterdir() if file.name.endswith((".toml", ".csv"))]
    return {file.name.removesuffix(".toml"): file.read_text("utf-8") for file in sorted(entries, key=lambda f: f.name)}


def title(text: str) -> str:
    """The first line of an example, which says what it is."""
    return text.partition("\n")[0].removeprefix("# ")


def write_examples(path: Path, names: list[str]) -> list[str]:
    """Write the examples ``names``, the files that they read and their sensors' weights to the directory ``path``.

    Returns the names of the files.  Raises ``InputError`` as ``output_directory``.
    """
    known = examples()
    configs = {config for name in names if _toml(name) for config in _configs(known[name])}
    chosen = {*names, *configs} & known.keys()
    weights = {name for each in chosen if _toml(each) for name in _weights(each, known[each])}
    with output_directory(path, "examples") as folder:
        for name in chosen:
            (folder / _file(name)).write_text(known[name], encoding="utf-8", newline="\n")
        for name in weights:
            (folder / name).write_bytes((files("tfra.examples") / name).read_bytes())
    return sorted([*map(_file, chosen), *weights])


def _toml(name: str) -> bool:
    """Whether the example ``name`` is a CONFIG or a STUDY."""
    return not name.endswith(".csv")


def _file(name: str) -> str:
    """The file of the example ``name``."""
    return f"{name}.toml" if _toml(name) else name


def _configs(text: str) -> set[str]:
    """The names of the CONFIG files that a STUDY reads."""
    study = tomllib.loads(text)
    return {name.removesuffix(".toml") for name in (study.get("config", ""), *study.get("beside", []))}


def _weights(name: str, text: str) -> set[str]:
    """The files of weights that the CONFIG ``name`` reads, or that lie beside it for those who choose the estimator."""
    named = {f"{name}.weights.npz", tomllib.loads(text).get("estimator", {}).get("weights", "")} - {""}
    return {file for file in named if (files("tfra.examples") / file).is_file()}
