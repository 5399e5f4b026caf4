"""The register map as a page: PeakRDL's, put into one file that loads nothing."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

from tfra.runtime.scratch import scratch, temporary, writing

if TYPE_CHECKING:
    from systemrdl.node import AddrmapNode

_STYLE = re.compile(r'<link rel="stylesheet" href="([^?"]+)[^>]*>')
_SCRIPT = re.compile(r'<script src="([^?"]+)\?[^>]*></script>')
_ICON = re.compile(r'href="favicon.png"')
_FONT = re.compile(r"@font-face \{.*?\n\}", re.DOTALL)
_SOURCE = re.compile(r'url\("\.\./(fonts/FontAwesome/[\w-]+\.woff2)"\) format\("woff2"\)')
_FORMULAS = re.compile(r'<script async src="[^"]*MathJax.js">.*?</script>.*?</script>', re.DOTALL)

_INSIDE = """<script>
const FILES = %s;
window.fetch = async path => new Response(FILES[path.split("?")[0]]);
const MathJax = {Hub: {Queue() {}}};
</script>"""
"""The scripts of the page fetch the text of a register when it is chosen, and pass it to MathJax for its formulas."""


def page(top: AddrmapNode) -> str:
    """An HTML page of the elaborated map ``top``: a register at a time, with its fields, and a search."""
    from peakrdl_html import HTMLExporter

    with scratch(temporary()) as folder, writing(folder.parent):
        exporter = HTMLExporter(user_context={"build_ts": 0}, generate_source_links=False)
        exporter.export(top, str(folder / "page"), title=top.get_property("name"))
        return _one_file(folder / "page")


def _one_file(folder: Path) -> str:
    """What PeakRDL wrote to ``folder`` as one text: styles and scripts in their places, all other texts in a table."""
    texts = {
        file.relative_to(folder).as_posix(): file.read_text(encoding="utf-8")
        for part in ("content", "data", "search")
        for file in sorted((folder / part).glob("*.*"))
    }
    inside = _INSIDE % json.dumps(texts, ensure_ascii=False).replace("</", "<\\/")
    text = (folder / "index.html").read_text(encoding="utf-8")
    text = _FORMULAS.sub(lambda _: inside, text)
    text = _ICON.sub('href="data:,"', text)
    text = _STYLE.sub(lambda match: f"<style>{_style(folder, match[1])}</style>", text)
    return _SCRIPT.sub(lambda match: f"<script>{(folder / match[1]).read_text(encoding='utf-8')}</script>", text)


def _style(folder: Path, name: str) -> str:
    """A style sheet with the font of its icons; texts are in the fonts of the reader's system."""

    def font(match: re.Match[str]) -> str:
        source = _SOURCE.search(match[0])
        if source is None:
            return ""
        data = base64.b64encode((folder / source[1]).read_bytes()).decode()
        family = re.findall(r"font-(?:family|weight|style):.*?;", match[0])
        return f'@font-face {{ {" ".join(family)} src: url("data:font/woff2;base64,{data}") format("woff2"); }}'

    return _FONT.sub(font, (folder / name).read_text(encoding="utf-8"))
