"""The site of docs/ builds without a warning, has every page, and loads nothing from anywhere else."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import tfra

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"

pytestmark = pytest.mark.long

FOREIGN = r"""["']?(?:https?:)?//"""
LOADS = re.compile(rf"<(?:script|img|iframe|link)\b[^>]*(?:src|href)={FOREIGN}|url\({FOREIGN}|@import")
"""What makes a browser load a file of another host."""


def build(source: Path, out: Path) -> str:
    """Build the site as ``make docs`` does; return its warnings, which are '' exactly if it succeeds."""
    options = ["-q", "-E", "-W", "--keep-going", "-d", str(out / "doctrees")]
    command = [sys.executable, "-m", "sphinx", *options, str(source), str(out / "html")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode == 0) == (done.stderr == ""), done.stderr
    return done.stderr


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site")
    assert build(DOCS, out) == ""
    return out / "html"


def test_every_page_is_there(site: Path) -> None:
    """Sphinx warns of a page without a place in a list: see below."""
    pages = {str(page.relative_to(DOCS).with_suffix("")) for page in DOCS.rglob("*.md")}
    contents = (site / "index.html").read_text()
    assert pages - {page for page in pages if f'href="{page}.html"' in contents} == {"index"}


def test_every_public_name_is_explained(site: Path) -> None:
    page = (site / "api.html").read_text()
    assert {name for name in tfra.__all__ if f'id="tfra.{name}"' not in page} == {"__version__"}


def test_no_file_names_another_host_to_load_from(site: Path) -> None:
    files = [file for kind in ("*.html", "*.css") for file in site.rglob(kind)]
    assert len(files) > 30
    assert [str(file) for file in files if LOADS.search(file.read_text())] == []
    assert LOADS.search('<link rel="stylesheet" href="https://fonts.example/font.css">')
