"""Pages of HTML: each is one file that loads nothing."""

import base64
import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

CSS = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; color: #111;
  overflow-wrap: break-word; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: .5rem 0 1rem; }
h2 { font-size: 1.2rem; margin: 2.5rem 0 .3rem; }
p { max-width: 50rem; margin: .4rem 0; }
a { color: #0058a0; }
.answer { font-size: 1.15rem; line-height: 1.45; border-left: 4px solid #0072B2; padding-left: .8rem; margin: 1rem 0; }
.failed { border-left-color: #b00020; }
.note, .caption { color: #444; font-size: .9rem; }
nav ul { list-style: none; padding: 0; margin: 1rem 0; display: flex; flex-wrap: wrap; gap: .2rem 1.1rem; }
.bars { width: 100%; max-width: 50rem; margin: .4rem 0 .9rem; }
.bars tbody { border: 0; }
.bars .name { white-space: normal; font-weight: normal; }
.bar { width: 50%; min-width: 7rem; padding: .15rem 0;
  background: linear-gradient(#ddd, #ddd) left / 100% .9rem no-repeat; }
.bar span { display: block; height: .9rem; background: #0072B2; }
sub, sup { line-height: 0; }
img { max-width: 100%; height: auto; display: block; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; font-variant-numeric: tabular-nums; }
th, td { padding: .15rem .45rem; text-align: right; }
td { white-space: nowrap; }
thead th { border-bottom: 2px solid #111; vertical-align: bottom; }
tbody { border-bottom: 1px solid #999; }
.name { text-align: left; }
@media (max-width: 640px) {
  td.name { white-space: normal; min-width: 7rem; }
  .bar { width: 35%; min-width: 5rem; }
}
"""

_SYMBOL = re.compile(r"(?<!\w)([A-Za-zα-ωµ])([_^])([a-z]{1,3})(?![A-Za-z_])")
"""A letter with what stands below or above it; names of columns and signals are longer."""

_CODE = re.compile("`([^`]*)`")


@dataclass(frozen=True)
class Section:
    """A part of a page under a heading, to which the contents link by ``name``."""

    name: str
    title: str
    parts: Sequence[str]

    def html(self) -> str:
        """Return the heading and the parts."""
        body = "\n".join(self.parts)
        return f'<section><h2 id="{self.name}">{text(self.title)}</h2>\n{body}</section>'


def page(title: str, opening: Iterable[str], sections: Sequence[Section], style: str = "") -> str:
    """A page: its ``opening``, links to the ``sections``, and these; ``style`` is added to ``CSS``."""
    links = contents({section.name: section.title for section in sections})
    return document(title, [*opening, links, *(section.html() for section in sections)], style)


def document(title: str, parts: Iterable[str], style: str = "", head: str = "") -> str:
    """The page of ``parts`` under its title; ``style`` is added to ``CSS``, ``head`` to the head."""
    icon = '<link rel="icon" href="data:,">'
    viewport = '<meta name="viewport" content="width=device-width, initial-scale=1">'
    heading = f'<meta charset="utf-8">{viewport}{head}<title>{escape(title)}</title>{icon}<style>{CSS}{style}</style>'
    body = "\n".join(parts)
    content = f"<h1>{escape(title)}</h1>\n{body}"
    return f'<!DOCTYPE html>\n<html lang="en"><head>{heading}</head><body>\n{content}\n</body></html>\n'


def text(words: str) -> str:
    """``words`` for a page, with symbols as they are printed: B^z gets a superscript, F_x and φ_ref a subscript.

    What stands between backticks is code, without symbols.
    """
    pieces = _CODE.split(escape(words))
    pieces[::2] = (_SYMBOL.sub(_symbol, piece) for piece in pieces[::2])
    pieces[1::2] = (f"<code>{piece}</code>" for piece in pieces[1::2])
    return "".join(pieces)


def _symbol(match: re.Match[str]) -> str:
    tag = "sup" if match[2] == "^" else "sub"
    return f"{match[1]}<{tag}>{match[3]}</{tag}>"


def paragraph(words: str, kind: str = "") -> str:
    """A paragraph of ``words``, as :func:`text`; ``kind``: ``answer``, ``answer failed``, ``note`` or ``caption``."""
    named = f' class="{kind}"' if kind else ""
    return f"<p{named}>{text(words)}</p>"


def image(label: str, svg: bytes) -> str:
    """A picture within the page; ``label`` is for readers who do not see it."""
    return f'<img alt="{escape(label)}" src="data:image/svg+xml;base64,{base64.b64encode(svg).decode()}">'


def data_script(name: str, data: Any) -> str:
    """``data`` as JSON for the scripts of a page, in an element with the id ``name``; no text in it can end it."""
    encoded = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return f'<script type="application/json" id="{name}">{encoded}</script>'


def contents(titles: Mapping[str, str]) -> str:
    """Links to the headings of a page, titles by their ids; nothing where there are none."""
    links = "".join(f'<li><a href="#{name}">{text(title)}</a></li>' for name, title in titles.items())
    return f'<nav aria-label="Contents"><ul>{links}</ul></nav>' if titles else ""


def grid(
    label: str, header: Sequence[str], groups: Iterable[Iterable[str]], names: Collection[int], **data: str
) -> str:
    """A table of groups of rows that may be wider than the page; the columns ``names`` hold words.

    ``label`` is as in :func:`wide`, ``data`` are attributes for tests and scripts.
    """
    kinds = (' class="name"' if column in names else "" for column in range(len(header)))
    cells = (f'<th scope="col"{kind}>{text(cell)}</th>' for kind, cell in zip(kinds, header, strict=True))
    head = "".join(cells).replace("/ ", "/&nbsp;")
    bodies = "\n".join("<tbody>" + "\n".join(rows) + "</tbody>" for rows in groups)
    table = f"<table{attributes(data)}><thead><tr>{head}</tr></thead>\n{bodies}</table>"
    return wide(label, table)


def wide(label: str, table: str) -> str:
    """A ``table`` that scrolls where it is wider than the page; ``label`` is its name for readers who do not see it."""
    return f'<div class="wide" tabindex="0" role="region" aria-label="{escape(label)}">{table}</div>'


def bars(label: str, rows: Sequence[tuple[str, float, str]], wholes: Sequence[float] = ()) -> str:
    """A bar for each name: its share of the full width, 0 ... 1, and the words behind it.

    ``wholes`` are the widths of what the bars are parts of, by default all of the full width.
    """
    lines = "".join(
        f'<tr><th scope="row" class="name">{text(name)}</th>'
        f'<td class="bar" style="background-size:{100 * whole:.1f}% .9rem">'
        f'<span style="width:{100 * min(max(share, 0.0), 1.0):.1f}%"></span></td>'
        f'<td class="name">{text(words)}</td></tr>'
        for (name, share, words), whole in zip(rows, wholes or [1.0] * len(rows), strict=True)
    )
    return f'<table class="bars" aria-label="{escape(label)}"><tbody>{lines}</tbody></table>'


def row(cells: Sequence[str], names: Collection[int], kind: str = "", **data: str) -> str:
    """A row of a table; the columns ``names`` hold words, ``kind`` is its class."""
    named = f' class="{kind}"' if kind else ""
    kinds = (' class="name"' if column in names else "" for column in range(len(cells)))
    columns = "".join(f"<td{kind}>{escape(cell)}</td>" for kind, cell in zip(kinds, cells, strict=True))
    return f"<tr{named}{attributes(data)}>{columns}</tr>"


def attributes(data: Mapping[str, str]) -> str:
    """``data`` as attributes of an element, for tests and scripts."""
    return "".join(f' data-{name}="{escape(value)}"' for name, value in data.items())
