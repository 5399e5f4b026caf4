"""The report: self-contained pages without script or outside resource, pictures first."""

from collections.abc import Sequence
from html import escape
from itertools import groupby
from pathlib import Path

from tfra.paper.picture import Picture, Text
from tfra.paper.tables import HEADER, MAXIMA_HEADER, Cells, Table
from tfra.report.html import contents, document, grid, image, row, text

STYLE = """
tr.published { background: #f3f0e6; }
dl { max-width: 60rem; }
dt { font-weight: 600; }
dd { margin: 0 0 .4rem; }
"""

SHORT = {
    "phi_ref_deg": "φ_ref / °", "method": "",
    "Fx_ref_N": "F_x ref / N", "Fx_N": "F_x / N", "e_Fx_percent": "paper’s e(F_x) / %",
    "Fy_ref_N": "F_y ref / N", "Fy_N": "F_y / N", "e_Fy_percent": "paper’s e(F_y) / %",
    "Fz_ref_N": "F_z ref / N", "Fz_N": "F_z / N", "e_Fz_percent": "paper’s e(F_z) / %",
    "mu_ref": "μ ref", "mu": "μ", "e_mu_percent": "paper’s e(μ) / %",
    "phi_deg": "φ / °", "e_phi_percent": "paper’s e(φ) / %", "e_F_percent": "paper’s e(F) / %",
    "error_phi_deg": "error of φ / °", "error_mu_abs": "error of μ", "error_force_n": "error of F / N",
    "error_force_percent_of_resultant": "error of F / % of |F|",
}  # fmt: skip
"""Headings of the CSV files as a reader likes them."""

INTRODUCTION = """
<p>Tables and figures of Pinto-Salamanca et al., <em>An estimation of triaxial forces from normal stress tactile sensor
arrays</em>, Mechatronics 2023, <a href="https://doi.org/10.1016/j.mechatronics.2023.103070">doi
10.1016/j.mechatronics.2023.103070</a>, computed again.</p>
"""

NOTES = """
<p>The paper’s frames are from finite elements. Neither they nor the sizes of the contacts are public. Here, frames are
an exact solution of an elastic layer under the contacts of <code>examples/*.toml</code>. Published numbers are copied
from Tables 1 and 2; every error is recomputed from them.</p>
<p>The paper measures errors in percent: e(F) is the error of a force component over the |F| found (Eq. 35), e(μ) that
of μ over 1 (Eq. 33), e(φ) that of φ over a full turn (Eq. 34). Errors in plain units stand beside them: degrees for φ,
the difference for μ, newtons and percent of the reference’s |F| for the force vector.</p>
<p>Figures 1 and 3 show no data. Beside this page are a CSV and an SVG file of each figure, and a CSV file of each
table.</p>
"""

TIMING = """
<h2 id="fig9">Fig. 9: Execution time for one frame</h2>
<p>Times change from run to run, everything else does not. They have <a href="fig9.html">a page</a> and files (fig9.*)
of their own, so that two runs give the same bytes in all other files.</p>
"""


def index(folder: Path, tables: Sequence[Table], pictures: Sequence[Picture], versions: dict[str, str]) -> str:
    """The whole report but the times, with the SVG files of ``folder``: summary, contents, figures, tables."""
    items: list[Picture | Table] = [*pictures, *tables]
    titles = {item.name: _heading(item) for item in items}
    links = {**titles, "fig9": "Fig. 9: Execution time", "versions": "Made with"}
    sections = [*(_picture(folder, picture) for picture in pictures), TIMING, *(_table(table) for table in tables)]
    parts = [INTRODUCTION, *map(_summary, tables), NOTES, contents(links), *sections, _versions(versions)]
    return document("The paper's tables and figures, computed again", parts, STYLE)


def _summary(table: Table) -> str:
    """Largest errors of one contact, beside those that the paper states."""
    measures = (("forces", "force"), ("μ", "mu"), ("φ", "phi"))
    ours, theirs = table.largest["TFRA, float"], table.largest["printed in the paper's text"]
    errors = ", ".join(f"{ours[key]:.2f}&nbsp;% in {name} (paper: {theirs[key]:.2f}&nbsp;%)" for name, key in measures)
    contact = escape(table.title.removeprefix("Forces, "))
    return f'<p class="answer">TFRA’s largest errors for the {contact}, as the paper measures them: {errors}.</p>'


def alone(folder: Path, picture: Picture, versions: dict[str, str]) -> str:
    """One figure on a page of its own."""
    parts = [_picture(folder, picture), _versions(versions)]
    return document(_heading(picture), parts, STYLE)


def _heading(item: Picture | Table) -> str:
    label = item.name.replace("fig", "Fig. ").replace("table", "Table ")
    return item.title if label == item.name else f"{label}: {item.title}"


def _picture(folder: Path, picture: Picture) -> str:
    label = _heading(picture)
    drawn = image(label, (folder / f"{picture.name}.svg").read_bytes())
    return f'<h2 id="{picture.name}">{text(label)}</h2>\n{drawn}\n{_text(picture.text)}'


def _table(table: Table) -> str:
    groups = [list(rows) for _, rows in groupby(table.rows, key=lambda row: row[0])]
    return (
        f'<h2 id="{table.name}">{text(_heading(table))}</h2>\n'
        f"{_grid(table.name, HEADER, groups)}\n<h3>Largest errors</h3>\n"
        f"{_grid(f'{table.name}_maxima', MAXIMA_HEADER, [table.maxima])}\n{_text(table.text)}"
    )


def _grid(name: str, header: Sequence[str], groups: Sequence[Cells]) -> str:
    place = header.index("method")
    rows = ((_row(cells, place) for cells in group) for group in groups)
    return grid(f"{name}.csv", [SHORT[cell] for cell in header], rows, (place,), csv=f"{name}.csv")


def _row(cells: Sequence[str], place: int) -> str:
    return row(cells, (place,), "published" if cells[place].startswith(("published", "printed")) else "")


def _text(read: Text) -> str:
    names = {"Published": read.published, "Measured": read.measured, "Difference": read.why}
    return "<dl>" + "".join(f"<dt>{name}</dt><dd>{text(note)}</dd>" for name, note in names.items()) + "</dl>"


def _versions(versions: dict[str, str]) -> str:
    listed = ", ".join(f"{name} {v}" for name, v in versions.items())
    return f'<h2 id="versions">Made with</h2>\n<p>{escape(listed)}</p>'
