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
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.inputs import read_toml
from tfra.study.errors.cascade import SIGNED
from tfra.study.frames.frameset import Definition, blame
from tfra.study.schema import SearchSection, StudyDocument
from tfra.study.search.costs import COSTS
from tfra.study.search.evaluate import LEAST
from tfra.study.search.space import Space
from tfra.study.skins.studyfile import SkinStudy

MOST_OPTIONS = 4096
"""Of one name of a space."""


@dataclass(frozen=True)
class StudyFile:
    """The content of a STUDY file; ``space`` is None if the study chooses it.

    ``beside`` are other designs of the sensor, by the names of their files.
    """

    path: Path
    document: StudyDocument
    project: Project
    design: Design
    beside: tuple[tuple[str, Design], ...]
    definition: Definition
    space: Space | None
    target: Target | None

    @property
    def inputs(self) -> list[Path]:
        """Files that the study reads."""
        recording = self.document.frames.recording
        others = [self.path.parent / name for name in self.document.beside]
        return [
            *(self.path, self.project.path, *others, *([self.weights] if self.weights else [])),
            *([] if recording is None else [self.path.parent / recording]),
        ]

    @property
    def weights(self) -> Path | None:
        """The file of weights that CONFIG names."""
        return self.project.path.parent / self.project.weights if self.project.weights else None


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
    beside = tuple(_beside(path, document, design.sensor))
    definition = Definition.of(path, design.sensor, project.layer, document.frames, design.adc, project.input)
    _require_frames(path, document)
    space, target = None, None
    for name in ("verify", "synth", "place"):
        if getattr(document, name) and not document.search:
            raise InputError(path, name, "needs a section [search], whose designs it takes")
    if document.search:
        with blame(path, "search"):
            target = _target(document.search, design)
            space = _space(document.search.space, design) if document.search.space else None
    return StudyFile(path, document, project, design, beside, definition, space, target)


def _beside(path: Path, document: StudyDocument, sensor: SensorArray) -> Iterator[tuple[str, Design]]:
    """The other designs by the names of their files; raises ``InputError``."""
    names = {Path(document.config).stem}
    for key, file in enumerate(document.beside, 1):
        project = load(path.parent / file)
        project.require_array("tfra study")
        if (name := project.path.stem) in names:
            raise InputError(path, f"beside#{key}", f"{name} is there twice")
        if project.design.sensor != sensor:
            raise InputError(path, f"beside#{key}", f"{file} is of another sensor than {document.config}")
        names.add(name)
        yield name, project.design


def _require_frames(path: Path, document: StudyDocument) -> None:
    """Raise if a part has too few frames for its tasks; the number of frames that count is known later."""
    if not document.frames.train:
        raise InputError(path, "frames.train", "at least one is needed, got none")
    for key in ("train", "held_out") if document.search else ():
        if (given := getattr(document.frames, key)) < LEAST:
            raise InputError(path, f"frames.{key}", f"[search] needs {LEAST} or more, got {given}")


def _target(section: SearchSection, design: Design) -> Target:
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


def _space(given: Mapping[str, Any], design: Design) -> Space:
    """The space of a table around ``design``; raises ``ValueError`` that starts with the key."""
    options = dict(_options(given, ""))
    try:
        space = Space(options)
        space.require_of(design)
        return space
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
