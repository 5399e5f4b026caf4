"""The study of a skin from its frames to its report."""

from collections.abc import Sequence
from dataclasses import dataclass

from tfra.families import DEFAULT
from tfra.runtime.errors import InputError
from tfra.study.errors.comparisons import converters, uniform
from tfra.study.frames.frameset import FrameSet, blame
from tfra.study.running import Running
from tfra.study.skins.page import render, summary
from tfra.study.skins.studyfile import SkinStudy
from tfra.study.skins.tasks import Contacts, SkinComparison


@dataclass
class SkinRun(Running):
    """A study of a skin."""

    study: SkinStudy

    def run_tasks(self) -> None:
        """Run all tasks of the file."""
        skin, document, frames = self.study.skin, self.study.document, self._make_frames()
        self._run_task(Contacts(skin, frames))
        if not self.tables["errors"]["count"].sum():
            raise InputError(self.study.path, "frames", "no step finds a contact that is there: no errors can be told")
        if document.uniform:
            varied = uniform(skin.window, document.uniform.bits, DEFAULT)
            self._run_task(SkinComparison("uniform", frames, varied, skin=skin))
        if given := document.converter:
            varied = converters(skin.window, given.bits, given.noise_share_of_peak)
            self._run_task(SkinComparison("converter", frames, varied, skin=skin))

    def answer(self) -> list[str]:
        """Conclusions."""
        return summary(self.tables, self.study.skin)

    def _make_frames(self) -> FrameSet:
        with blame(self.study.path, "frames"):
            return super()._make_frames()

    def _page(self, pending: Sequence[str] = ()) -> str:
        return render(self.tables, self.study.skin, pending)

    def _table_names(self) -> list[str]:
        return [*Contacts.makes, *(name for name in ("uniform", "converter") if getattr(self.study.document, name))]
