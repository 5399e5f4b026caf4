"""One text in two languages, and lines that a design leaves of it."""

import re
from pathlib import Path

import pytest

from tests.codegen.c.cases import SMALL
from tfra.codegen.blocks.dialect import in_c, in_cpp, resolved
from tfra.codegen.blocks.program import blocks

TEXT = """\
for (;;) {
    //+ #pragma
    here(); //+ there();
    here(); //+
    both(); // a comment

}
"""


def test_languages() -> None:
    assert in_c(TEXT) == "for (;;) {\n    here();\n    here();\n    both(); // a comment\n\n}\n"
    assert in_cpp(TEXT) == "for (;;) {\n    #pragma\n    there();\n    both(); // a comment\n\n}\n"


@pytest.mark.parametrize(
    ("true", "left"),
    [({"A"}, "0 1 4"), ({"B"}, "0 2 4"), ({"A", "B"}, "0 1 4"), ({"C"}, "0 3 4 5"), (set(), "0 3 4")],
)
def test_lines_that_are_left(true: set[str], left: str) -> None:
    text = "0\n#if A\n1\n#elif B\n2\n#else\n3\n#endif\n4\n#if C\n5\n#endif\n"
    assert resolved(text, true).split() == left.split()


OTHERS = {"normalize", "taxels", "products", "estimate"}
"""Primitives that NumPy has, and the chain of all blocks, `pipeline.py` in the model."""


@pytest.mark.parametrize("case", ["3x5", "learned_3x5"])
def test_blocks_have_the_names_of_the_model(case: str) -> None:
    names = {name.rpartition("/")[2] for name in blocks(SMALL[case])}
    assert names - {path.stem for path in Path("model/fixed").rglob("*.py")} == OTHERS


@pytest.mark.parametrize("case", SMALL)
def test_nothing_of_a_mark_is_left(case: str) -> None:
    for name, text in blocks(SMALL[case]).items():
        assert not re.search(r"//\+|#(if|el|endif)", in_c(text) + in_cpp(text)), name
