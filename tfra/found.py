"""The result of ``Skin.estimate``: contacts, their forces, tracks and files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tfra.codegen.config.read import Project
from tfra.contacts import Truth
from tfra.model.arrays import Floats
from tfra.model.metrics import Some, errors
from tfra.model.skin.matching import matched, seen_at
from tfra.model.skin.result import SkinResult
from tfra.recordings.frames import Recording
from tfra.recordings.results import SkinEstimate, check_result, write_result
from tfra.recordings.skin_facts import skin_facts, skin_lines
from tfra.result import Errors, Page
from tfra.runtime.errors import InputError, require
from tfra.runtime.outputs import check_file, write_text
from tfra.tables import dataframe, html_table

if TYPE_CHECKING:
    import polars as pl


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Contacts(SkinResult):
    """k contacts in n frames; printing them gives a summary, and ``table`` all values, a row for each contact.

    Of shape ``(k,)``: the ``frame``, the number of the ``contact`` in it, ``x`` and ``y`` of the region's centroid in m
    from the first taxel, ``taxels`` of the region, ``top`` and ``left``, the first row and column of the window.
    ``windows``: a ``tfra.Result`` without its methods, with a frame for each contact.  ``found`` and
    ``dropped (n,)``: contacts of each frame, and peaks beyond as many as there may be.  ``notices``: the warnings of
    ``Skin.estimate``.
    """

    project: Project
    recording: Recording
    engine: str
    notices: tuple[str, ...] = ()

    @property
    def stress(self) -> Floats:
        """``(n, rows, columns)``: the input stress, Pa, compression negative."""
        return self.recording.frames

    @property
    def table(self) -> Mapping[str, npt.NDArray[Any]]:
        """Columns by their names, each ``(k,)``: those of contacts.csv in docs/recordings.md."""
        return self._written().tables()["contacts"]

    def __len__(self) -> int:
        return len(self.frame)

    def __repr__(self) -> str:
        text = "\n  ".join([*skin_lines(skin_facts(self)), *(f"warning: {notice}" for notice in self.notices)])
        return f"<tfra.Contacts of the {self.engine} engine\n  {text}>"

    def _repr_html_(self) -> str:
        return html_table(self.table)

    def to_dataframe(self) -> pl.DataFrame:
        """Return ``table`` as one of polars; ``to_pandas()`` of that needs pandas.

        Raises ``tfra.InputError`` where polars is missing (``pip install 'tfra[tables]'``).
        """
        return dataframe("Contacts.to_dataframe", self.table)

    def errors(self, truth: Truth) -> ContactErrors:
        """Compare with ``truth``, from ``Skin.simulate``; a contact and the true one next to it belong together.

            >>> skin = tfra.load_skin("examples/fingers_32x32.toml")
            >>> frames, truth = skin.simulate()
            >>> errors = skin.estimate(frames, engine="c").errors(truth)
            >>> errors.missed, errors.invented
            (0, 0)

        ``print(errors)`` has the medians and 95th percentiles.  Raises ``tfra.InputError`` for a ``truth`` of frames
        that are not here.
        """
        frame = np.arange(len(truth)) if truth.frame is None else truth.frame
        if frame.max(initial=0) >= len(self.found):
            raise InputError("Contacts.errors", "truth", f"is of {frame.max() + 1} frames, there are {len(self.found)}")
        assert self.project.skin
        sensor = self.project.skin.sensor
        center = truth.arrays()["contact_center"]
        here = np.stack([self.x, self.y], axis=1) / np.array([sensor.pitch_x, sensor.pitch_y])
        true, seen = matched((frame, self.frame), (seen_at(center, truth.resultant, sensor), here))
        known, found = (Some.of(every, which) for every, which in ((truth, true), (self.windows, seen)))
        return ContactErrors(errors(known, found), len(truth) - len(true), len(self) - len(seen))

    def save(self, path: str | Path) -> None:
        """Write the contacts as ``tfra estimate`` does: an archive .npz, a folder .csv, .parquet or .mcap.

        ``path`` and errors are those of ``tfra.Result.save``.
        """
        file, inputs = Path(path), [self.project.path]
        check_result(file, "estimate", inputs)
        write_result(file, self._written(), "estimate", inputs)

    def view(self, path: str | Path | None = None) -> Page:
        """Make an interactive page: a map with a numbered arrow a contact, a table of contacts, forces over the frames.

        ``path``, the page and errors are those of ``tfra.Result.view``.
        """
        require("Contacts.view", "view", "plotly")
        from tfra.view.skin_page import chosen_frames, render_skin
        from tfra.view.skinfile import RecordedSkin

        file = None if path is None else Path(path)
        if file:
            check_file(file, ".html", "view", [self.project.path])
        assert self.project.skin
        of = self.recording
        shown = RecordedSkin("contacts", self.engine, self.project.skin, self, self.stress, of.time, of.dead)
        page = render_skin(shown, chosen_frames(shown, range(len(self.stress))))
        if file:
            write_text(file, page, "view")
        return Page(page, file)

    def _written(self) -> SkinEstimate:
        return SkinEstimate(self.recording, self, self.engine, self.project.text())


class ContactErrors(Errors):
    """Errors of the contacts that were found, ``(p,)``, and how many were ``missed`` or ``invented``."""

    def __init__(self, values: Mapping[str, Floats], missed: int, invented: int) -> None:
        super().__init__(values)
        self.missed = missed
        self.invented = invented

    def __repr__(self) -> str:
        return f"{super().__repr__()}\nmissed {self.missed}, invented {self.invented}"
