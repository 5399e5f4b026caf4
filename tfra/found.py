"""The result of ``Skin.estimate``: contacts, their forces, tracks and files."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy.typing as npt

from tfra.codegen.config.read import Project
from tfra.model.arrays import Floats
from tfra.model.skin.result import SkinResult
from tfra.recordings.frames import Recording
from tfra.recordings.results import SkinEstimate, check_result, write_result
from tfra.recordings.skin_facts import skin_facts, skin_lines
from tfra.result import Page
from tfra.runtime.errors import require
from tfra.runtime.outputs import check_file, write_text

SHOWN = 12
"""Contacts of a table in a notebook."""


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
        columns = {name: values[:SHOWN].tolist() for name, values in self.table.items()}
        head = "".join(f"<th>{escape(name)}</th>" for name in columns)
        rows = ("".join(f"<td>{value:.5g}</td>" for value in row) for row in zip(*columns.values(), strict=True))
        return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"

    def save(self, path: str | Path) -> None:
        """Write the contacts as ``tfra estimate`` does: an archive .npz, a folder .csv, .parquet or .mcap.

        ``path`` and errors are those of ``tfra.Result.save``.
        """
        file, inputs = Path(path), [self.project.path]
        check_result(file, "estimate", inputs, skin=True)
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
        shown = RecordedSkin("contacts", self.engine, self.project.skin, self, self.stress, self.recording.time)
        page = render_skin(shown, chosen_frames(shown, range(len(self.stress))))
        if file:
            write_text(file, page, "view")
        return Page(page, file)

    def _written(self) -> SkinEstimate:
        return SkinEstimate(self.recording, self, self.engine, self.project.text())
