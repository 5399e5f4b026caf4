"""From a STUDY file of a skin to its frames, checked."""

from dataclasses import dataclass
from pathlib import Path

from tfra.codegen.config.read import Project
from tfra.model.skin.skin import Skin
from tfra.runtime.errors import InputError
from tfra.study.frames.frameset import Definition
from tfra.study.schema import StudyDocument
from tfra.study.skins.crowds import definition

OF_SKINS = ("config", "frames", "uniform", "converter")
"""Keys of a STUDY file that a skin can have."""


@dataclass(frozen=True)
class SkinStudy:
    """The content of a STUDY file whose CONFIG is that of a ``skin``."""

    path: Path
    document: StudyDocument
    project: Project
    skin: Skin
    definition: Definition

    @property
    def inputs(self) -> list[Path]:
        """Files that the study reads."""
        weights = [self.project.path.parent / self.project.weights] if self.project.weights else []
        return [self.path, self.project.path, *weights]

    @classmethod
    def of(cls, path: Path, document: StudyDocument, project: Project, skin: Skin) -> "SkinStudy":
        """The study of a checked document; raises ``InputError`` that names the file, the key and the reason."""
        for key in document.model_fields_set:
            if key not in OF_SKINS:
                raise InputError(path, key, f"a study of a skin has only {', '.join(OF_SKINS)}")
        return cls(path, document, project, skin, definition(path, skin, project.layer, document.frames))
