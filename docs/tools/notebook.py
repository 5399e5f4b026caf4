"""Runs docs/notebook.ipynb and saves its outputs in it: ``python -m docs.tools.notebook``.

A notebook is run here as Jupyter runs it, cell by cell in one namespace, without Jupyter: what is printed, warnings,
figures and the value of the last line are the outputs of a cell.  Lines that begin with ``!tfra`` are commands.
"""

import ast
import base64
import io
import json
import shlex
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import chdir, redirect_stdout
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib import pyplot

from tfra.cli.main import main as tfra
from tfra.runtime.errors import Notice

NOTEBOOK = Path(__file__).parents[1] / "notebook.ipynb"

Output = dict[str, Any]
"""As nbformat 4.5 has it."""


def read() -> dict[str, Any]:
    """The notebook as it is saved."""
    found: dict[str, Any] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    return found


def executed(notebook: dict[str, Any]) -> list[list[Output]]:
    """The outputs of every code cell, run in the current folder."""
    mpl.use("Agg")
    names: dict[str, Any] = {"__name__": "__main__", "_command": _command}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    return [list(_outputs("".join(cell["source"]), names, number)) for number, cell in enumerate(cells, 1)]


def _outputs(source: str, names: dict[str, Any], number: int) -> Iterator[Output]:
    """Run one cell; an error in it is an error here."""
    printed, value = io.StringIO(), None
    with redirect_stdout(printed), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("error")
        warnings.simplefilter("always", Notice)
        tree = ast.parse("\n".join(_python(line) for line in source.splitlines()))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, f"cell {number}", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), names)
    doubts = "".join(f"{each.category.__name__}: {each.message}\n" for each in warned)
    for name, text in {"stdout": printed.getvalue(), "stderr": doubts}.items():
        if text:
            yield {"name": name, "output_type": "stream", "text": text.splitlines(keepends=True)}
    for figure in map(pyplot.figure, pyplot.get_fignums()):
        yield {"data": _picture(figure), "metadata": {}, "output_type": "display_data"}
    pyplot.close("all")
    if value is not None and not source.endswith(";"):
        yield {"data": _shown(value), "execution_count": number, "metadata": {}, "output_type": "execute_result"}


def _python(line: str) -> str:
    return f"_command({line[1:]!r})" if line.startswith("!") else line


def _command(line: str) -> None:
    """Run ``tfra ...``; raises ``ValueError`` for another program, and where it fails."""
    program, *arguments = shlex.split(line)
    if program != "tfra" or tfra(arguments):
        raise ValueError(f"{line}: failed")


def _picture(figure: Any) -> dict[str, str]:
    """A figure as Jupyter has it; without the version of Matplotlib, so that equal pictures are equal bytes."""
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=80, bbox_inches="tight", metadata={"Software": None})
    return {"image/png": base64.b64encode(data.getvalue()).decode()}


def _shown(value: Any) -> dict[str, list[str]]:
    found = {"text/plain": repr(value)}
    if hasattr(value, "_repr_html_"):
        found["text/html"] = value._repr_html_()
    return {kind: text.splitlines(keepends=True) for kind, text in found.items()}


def main() -> None:
    """Run the notebook and save it with its new outputs."""
    notebook = read()
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        found = executed(notebook)
    code = (cell for cell in notebook["cells"] if cell["cell_type"] == "code")
    for number, (cell, outputs) in enumerate(zip(code, found, strict=True), 1):
        cell.update(execution_count=number, outputs=outputs)
    NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
