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
.name { text-align: left; }
"""


def document(title: str, parts: Iterable[str], style: str, head: str = "") -> str:
    """The page of ``parts`` under its title; ``style`` is added to ``CSS``, ``head`` to the head."""
    icon = '<link rel="icon" href="data:,">'
    heading = f'<meta charset="utf-8">{head}<title>{escape(title)}</title>{icon}<style>{CSS}{style}</style>'
    body = "\n".join(parts)
    content = f"<h1>{escape(title)}</h1>\n{body}"
    return f'<!DOCTYPE html>\n<html lang="en"><head>{heading}</head><body>\n{content}\n</body></html>\n'


def grid(header: Sequence[str], groups: Iterable[Iterable[str]], names: Collection[int], **data: str) -> str:
    """A table of groups of rows that may be wider than the page; the columns ``names`` hold words.

    ``data`` are attributes for tests and scripts.
    """
    head = _cells("th", header, names).replace("/ ", "/&nbsp;")
    bodies = "\n".join("<tbody>" + "\n".join(rows) + "</tbody>" for rows in groups)
    table = f"<table{_attributes(data)}><thead><tr>{head}</tr></thead>\n{bodies}</table>"
    return f'<div class="wide">{table}</div>'


def row(cells: Sequence[str], names: Collection[int], kind: str = "", **data: str) -> str:
    """A row of a table; the columns ``names`` hold words, ``kind`` is its class."""
    named = f' class="{kind}"' if kind else ""
    return f"<tr{named}{_attributes(data)}>{_cells('td', cells, names)}</tr>"


def _cells(tag: str, cells: Sequence[str], names: Collection[int]) -> str:
    kinds = (' class="name"' if place in names else "" for place in range(len(cells)))
    return "".join(f"<{tag}{kind}>{escape(cell)}</{tag}>" for kind, cell in zip(kinds, cells, strict=True))


def _attributes(data: dict[str, str]) -> str:
    return "".join(f' data-{name}="{escape(value)}"' for name, value in data.items())
