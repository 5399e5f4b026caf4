"""What docs/library.md and docs/notebook.ipynb show is what comes out."""

import copy
import doctest
import re
from pathlib import Path
from typing import Any

import pytest

from docs.tools.notebook import Output, executed, read

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(DOCS.parent / "examples")


def failures(text: str) -> int:
    """Run the examples of a page in one namespace; an unfinished or wrong one counts."""
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    test = doctest.DocTestParser().get_doctest("".join(blocks), {}, "library.md", "library.md", 0)
    runner = doctest.DocTestRunner(verbose=False)
    found = runner.run(test)
    assert found.attempted > 10
    return int(found.failed)


def test_the_page() -> None:
    text = (DOCS / "library.md").read_text()
    assert failures(text) == 0
    assert failures(text.replace("0.0513", "0.0514")) == 1


def test_every_call_of_the_page_is_there() -> None:
    import tfra

    rows = re.findall(r"^\| `(tfra|sensor|result)\.(\w+)\(", (DOCS / "library.md").read_text(), re.MULTILINE)
    homes = {"tfra": tfra, "sensor": tfra.Sensor, "result": tfra.Result}
    assert len(rows) == 9
    assert all(hasattr(homes[home], name) for home, name in rows)


def texts(outputs: list[list[Output]]) -> list[list[Any]]:
    """All but the bytes of pictures, which depend on Matplotlib's version."""
    shown = copy.deepcopy(outputs)
    for cell in shown:
        for output in cell:
            if "image/png" in output.get("data", {}):
                output["data"]["image/png"] = len(output["data"]["image/png"]) > 5000
    return shown


def test_the_notebook() -> None:
    notebook = read()
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    saved = texts([cell["outputs"] for cell in cells])
    found = texts(executed(notebook))
    assert saved == found
    kinds = [output["output_type"] for cell in found for output in cell]
    assert (kinds.count("display_data"), kinds.count("execute_result") > 3) == (2, True)
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    made = {"skin.toml", "example", "learned.toml", "page.html", "log.csv", "forces.csv"}
    assert {path.name for path in Path().iterdir()} == {"examples", *made}
