"""From a STUDY file to a design, frames, and a search space, each checked."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tfra.codegen.config.complaints import complaint
from tfra.codegen.config.read import Project, load
from tfra.families import Target, find
from tfra.hdl.cores import microarchitecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.inputs import read_toml
from tfra.study.errors.cascade import SIGNED
from tfra.study.frames.frameset import Definition, blame
from tfra.study.schema import SearchSection, StudyDocument
from tfra.study.search.evaluate import COSTS, LEAST
from tfra.study.search.space import Space
from tfra.study.skins.studyfile import SkinStudy

MOST_OPTIONS = 4096
"""Of one name of a space."""


@dataclass(frozen=True)
class StudyFile:
    """The content of a STUDY file; ``space`` is None if the study chooses it."""

    path: Path
    document: StudyDocument
    project: Project
    design: TfraDesign
    definition: Definition
    space: Space | None
    target: Target | None

    @property
    def inputs(self) -> list[Path]:
        """Files that the study reads."""
        recording = self.document.frames.recording
        return [self.path, self.project.path, *([] if recording is None else [self.path.parent / recording])]


def load_study(path: Path) -> StudyFile | SkinStudy:
    """Read and check the STUDY file at ``path``, and the CONFIG file that it names.

    Raises ``InputError``, a line that names the file, the key and the reason, for anything wrong with them.
    """
    try:
        document = StudyDocument.model_validate(read_toml(path))
    except ValidationError as error:
        raise InputError(path, *complaint(error, StudyDocument)) from None
    project = load(path.parent / document.config)
    design = project.design
    with blame(project.path, ""):
        microarchitecture(design).check()
    if project.skin:
        return SkinStudy.of(path, document, project, project.skin)
    if not isinstance(design, TfraDesign):
        raise InputError(path, "config", "a design of the TFRA estimator is needed")
    definition = Definition.of(path, design.sensor, project.layer, document.frames, design.adc, project.input)
    _require_frames(path, document)
    space, target = None, None
    for name in ("verify", "place"):
        if getattr(document, name) and not document.search:
            raise InputError(path, name, "needs a section [search], whose designs are placed")
    if document.search:
        with blame(path, "search"):
            target = _target(document.search, design)
            space = _space(document.search.space) if document.search.space else None
    return StudyFile(path, document, project, design, definition, space, target)


def _require_frames(path: Path, document: StudyDocument) -> None:
    """Raise if a part has too few frames for its tasks; the number of frames that count is known later."""
    if not document.frames.train:
        raise InputError(path, "frames.train", "at least one is needed, got none")
    for key in ("train", "held_out") if document.search else ():
        if (given := getattr(document.frames, key)) < LEAST:
            raise InputError(path, f"frames.{key}", f"[search] needs {LEAST} or more, got {given}")


def _target(section: SearchSection, design: TfraDesign) -> Target:
    for key, known in (("costs", COSTS), ("errors", tuple(SIGNED))):
        names = getattr(section, key)
        for name in names:
            if name not in known:
                raise ValueError(f"{key}: one of {', '.join(known)} is needed, got {quoted(name)}")
        if len(set(names)) < len(names):
            raise ValueError(f"{key}: one of them is there twice")
    try:
        target = find(section.target)
    except ValueError as error:
        raise ValueError(f"target: {error}") from None
    if design.target not in ("portable", target.family.name):
        raise ValueError(f"target: {target.name} has no cells of {design.target}, which CONFIG wants")
    return target


def _space(given: Mapping[str, Any]) -> Space:
    """The space of a table; raises ``ValueError`` that starts with the key."""
    options = dict(_options(given, ""))
    try:
        return Space(options)
    except ValueError as error:
        raise ValueError(f"space.{error}" if options else str(error)) from None


def _options(given: Mapping[str, Any], above: str) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Names with their options; ``coefficient.c33 = ...`` is a table in a table for TOML."""
    for key, value in given.items():
        name = f"{above}{key}"
        if isinstance(value, dict) and set(value) != {"from", "to"}:
            yield from _options(value, f"{name}.")
        else:
            yield name, _choices(name, value)


def _choices(name: str, value: Any) -> tuple[int, ...]:
    if isinstance(value, dict):
        low, high = _whole(name, value["from"]), _whole(name, value["to"])
        if not low <= high < low + MOST_OPTIONS:
            raise ValueError(f"space.{name}: from {low} to {high} is no range to choose from")
        return tuple(range(low, high + 1))
    values = value if isinstance(value, list) else [value]
    return tuple(sorted({_whole(name, each) for each in values}))


def _whole(name: str, value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError(f"space.{name}: whole numbers, a list or {{from, to}}, are needed, got {quoted(value)}")
    return value
