"""The result of ``Sensor.estimate``: forces, their errors, files and an interactive page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tfra.codegen.config.read import Project
from tfra.model import tfra
from tfra.model.arrays import Floats
from tfra.model.metrics import ERRORS, Contact, errors
from tfra.recordings.facts import facts, lines
from tfra.recordings.frames import Recording
from tfra.recordings.results import Estimate, check_result, write_result
from tfra.runtime.errors import InputError, require
from tfra.tables import dataframe, html_table

if TYPE_CHECKING:
    import polars as pl

    from tfra.view.resultfile import Recorded, References


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Result(tfra.Result):
    """Forces of n frames; arrays have the same names as in result files.  Printing a result gives a summary.

    - ``forces (n, 3, rows, columns)``: f_x, f_y, f_z at every taxel, N; NaN from a core that leaves them out
    - ``resultant (n, 3)``: F_x, F_y, F_z, N; F_z < 0 presses
    - ``phi_deg (n,)``: direction of the tangential force, degrees in [0, 360)
    - ``mu (n,)``: friction coefficient, tangential over normal force; ``mu_x``, ``mu_y``: its components
    - ``sweep_index (n,)``: index of the candidate that the search chose
    - ``status (n,)``: bits of ``tfra.Status``; 0 if none is set
    - ``notices``: the warnings of ``Sensor.estimate``

    Of the learned estimator alone, else None: ``uncertainty (n,)``, how unsure it is of the resultant, N, no error bar;
    ``threshold`` of the uncertainty over ``|F_z|``, over which frames are ``IMPLAUSIBLE``; ``residual (n,)``, the share
    of the stress that the forces leave unexplained.
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
    def time(self) -> Floats | None:
        """``(n,)``: times of the frames, if the recording has them."""
        return self.recording.time

    def __len__(self) -> int:
        return len(self.mu)

    def __repr__(self) -> str:
        text = "\n  ".join([*lines(facts(self.stress, self)), *(f"warning: {n}" for n in self.notices)])
        return f"<tfra.Result of the {self.engine} engine, {len(self)} frames\n  {text}>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>{html_table(self.table)}"

    @property
    def table(self) -> Mapping[str, npt.NDArray[Any]]:
        """Columns by their names, a row for each frame: those of frames.csv in docs/recordings.md."""
        return Estimate(self.recording, self, self.engine, "").frames()

    def to_dataframe(self) -> pl.DataFrame:
        """Return ``table`` as one of polars; ``to_pandas()`` of that needs pandas.

            >>> sensor = tfra.load("examples/skin_8x12.toml")
            >>> sensor.estimate(sensor.simulate()[0]).to_dataframe()["mu"].len()
            12

        Raises ``tfra.InputError`` where polars is missing (``pip install 'tfra[tables]'``).
        """
        return dataframe("Result.to_dataframe", self.table)

    def errors(self, truth: Contact) -> Errors:
        """Compare with ``truth``, from ``Sensor.simulate``, or with another result of the same frames.

            >>> sensor = tfra.load("examples/skin_8x12.toml")
            >>> frames, truth = sensor.simulate()
            >>> errors = sensor.estimate(frames).errors(truth)
            >>> errors["mu_abs"].shape
            (12,)

        ``print(errors)`` has the medians and 95th percentiles.  Raises ``tfra.InputError`` for a ``truth`` of another
        number of frames.
        """
        _require_frames("Result.errors", truth, len(self))
        return Errors(errors(truth, self))

    def save(self, path: str | Path) -> None:
        """Write the result as ``tfra estimate`` does: an archive .npz, or a folder .csv, .parquet or .mcap.

        docs/recordings.md has the keys and the columns.  ``path`` may be missing, empty, or an earlier result that
        nobody has changed.  Raises ``tfra.InputError`` for anything else, and when the file can't be written.
        """
        file, inputs = Path(path), [self.project.path]
        check_result(file, "estimate", inputs)
        write_result(file, Estimate(self.recording, self, self.engine, self.project.text()), "estimate", inputs)

    def view(
        self,
        path: str | Path | None = None,
        *,
        truth: Contact | None = None,
        beside: Mapping[str, Result] | None = None,
    ) -> Page:
        """Make an interactive page of the result: stress, forces, friction and direction of every frame.

        With a ``path`` that ends in .html the page is written there, one file that loads nothing.  In a notebook the
        page shows itself.  ``truth`` is drawn with the result, and so are other results of the same frames,
        ``beside``, by their names:

            >>> sensor = tfra.load("examples/skin_8x12.toml")
            >>> frames, truth = sensor.simulate()
            >>> fixed, exact = sensor.estimate(frames, engine="fixed"), sensor.estimate(frames)
            >>> page = fixed.view("page.html", truth=truth, beside={"exact": exact})

        Raises ``tfra.InputError`` where plotly is missing (``pip install 'tfra[view]'``), for results of other frames
        or sensors, and when the file can't be written.
        """
        require("Result.view", "view", "plotly")
        from tfra.runtime.outputs import check_file, write_text
        from tfra.view.pack import Chosen
        from tfra.view.page import render, require_few

        file = None if path is None else Path(path)
        if file:
            check_file(file, ".html", "view", [self.project.path])
        results = [self._recorded("result")]
        for name, other in (beside or {}).items():
            if other.project.design.sensor != self.project.design.sensor or len(other) != len(self):
                raise InputError("Result.view", f"beside: {name}", "is of another sensor or number of frames")
            results.append(other._recorded(name))
        known = [] if truth is None else [_references(truth, len(self))]
        require_few(results, known)
        page = render(results, known, Chosen.of(results, range(len(self))))
        if file:
            write_text(file, page, "view")
        return Page(page, file)

    def _recorded(self, name: str) -> Recorded:
        from tfra.view.resultfile import Recorded

        design, of = self.project.design, self.recording
        return Recorded(name, self.engine, design, self, of.frames, of.time, design.sweeps, of.dead)


def _require_frames(call: str, truth: Contact, count: int) -> None:
    if len(truth.mu) != count:
        raise InputError(call, "truth", f"is of {len(truth.mu)} frames, the result has {count}")


def _references(truth: Contact, count: int) -> References:
    from tfra.view.resultfile import References

    _require_frames("Result.view", truth, count)
    values = {"resultant_ref": truth.resultant, "mu_ref": truth.mu, "phi_ref_deg": truth.phi_deg}
    return References("truth", values)


class Errors(Mapping[str, Floats]):
    """Errors of every frame, ``(n,)``, by the keys of ``tfra.model.metrics.ERRORS``; printed, a table of them.

    ``phi_deg`` in degrees, ``mu_abs``, ``force_n`` in N and ``force_percent_of_resultant`` are in plain units; three
    more are measured as the paper does (Eqs. 33-35).
    """

    def __init__(self, values: Mapping[str, Floats]) -> None:
        self._values = dict(values)

    def __getitem__(self, key: str) -> Floats:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def _rows(self) -> list[tuple[str, str, str]]:
        """Name, median and 95th percentile of each error."""
        percentiles = {key: np.percentile(values, (50, 95)) for key, values in self.items()}
        return [(ERRORS[key], f"{median:.3g}", f"{high:.3g}") for key, (median, high) in percentiles.items()]

    def __repr__(self) -> str:
        rows = [("", "median", "95 %"), *self._rows()]
        width = max(len(name) for name, _, _ in rows)
        return "\n".join(f"{name:{width}} {median:>8} {high:>8}" for name, median, high in rows)

    def _repr_html_(self) -> str:
        cells = "".join(
            f"<tr><th>{escape(name)}</th><td>{median}</td><td>{high}</td></tr>" for name, median, high in self._rows()
        )
        return f"<table><tr><th></th><th>median</th><th>95 %</th></tr>{cells}</table>"


@dataclass(frozen=True, repr=False)
class Page:
    """An interactive page; a notebook shows it, ``html`` is its text, ``path`` the file that was written, or None."""

    html: str
    path: Path | None

    def __repr__(self) -> str:
        return f"<tfra.Page: {self.path or 'not written'}>"

    def _repr_html_(self) -> str:
        """A written page is shown by its name, so that the notebook stays small."""
        source = f'src="{escape(str(self.path))}"' if self.path else f'srcdoc="{escape(self.html)}"'
        return f'<iframe {source} width="100%" height="900" style="border: 0"></iframe>'
