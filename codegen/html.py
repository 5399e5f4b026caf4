"""Pages of HTML: each is one file that loads nothing."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from html import escape

CSS = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; color: #111; }
img { max-width: 100%; height: auto; display: block; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; font-variant-numeric: tabular-nums; }
th, td { padding: .15rem .45rem; text-align: right; }
td { white-space: nowrap; }
thead th { border-bottom: 2px solid #111; vertical-align: bottom; }
tbody { border-bottom: 1px solid #999; }
td.name { text-align: left; }
"""


def document(title: str, parts: Iterable[str], style: str, head: str = "") -> str:
    """The page of ``parts`` under its title; ``style`` is added to ``CSS``, ``head`` to the head."""
    icon = '<link rel="icon" href="data:,">'
    heading = f'<meta charset="utf-8">{head}<title>{escape(title)}</title>{icon}<style>{CSS}{style}</style>'
    body = "\n".join(parts)
    content = f"<h1>{escape(title)}</h1>\n{body}"
    return f'<!DOCTYPE html>\n<html lang="en"><head>{heading}</head><body>\n{content}\n</body></html>\n'


def grid(header: Sequence[str], groups: Iterable[Iterable[str]], **data: str) -> str:
    """A table of groups of rows that may be wider than the page; ``data`` are attributes for tests and scripts."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header).replace("/ ", "/&nbsp;")
    bodies = "\n".join("<tbody>" + "\n".join(rows) + "</tbody>" for rows in groups)
    table = f"<table{_attributes(data)}><thead><tr>{head}</tr></thead>\n{bodies}</table>"
    return f'<div class="wide">{table}</div>'


def row(cells: Sequence[str], names: Collection[int], kind: str = "", **data: str) -> str:
    """A row of a table; the columns ``names`` hold words, ``kind`` is its class."""
    shown = (
        f'<td class="name">{escape(c)}</td>' if n in names else f"<td>{escape(c)}</td>" for n, c in enumerate(cells)
    )
    named = f' class="{kind}"' if kind else ""
    return f"<tr{named}{_attributes(data)}>{''.join(shown)}</tr>"


def _attributes(data: dict[str, str]) -> str:
    return "".join(f' data-{name}="{escape(value)}"' for name, value in data.items())
