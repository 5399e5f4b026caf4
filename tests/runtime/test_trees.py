"""Nothing that is not a command's own changes below random trees, and whoever loses a file is caught."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.runtime import trees

BEFORE: trees.Tree = {"/t/out": None, "/t/out/core.v": b"own", "/t/notes": b"mine", "/t/link": "link notes"}
OWN = {"/t/out/core.v": b"own"}
OUT = Path("/t/out")


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**9))
def test_random_trees(seed: int) -> None:
    command, code, wrong = trees.one_tree(seed)
    assert not wrong, command
    assert code in (0, 2)


def test_a_success_may_replace_its_own() -> None:
    assert trees.verdict(BEFORE, BEFORE | {"/t/out/core.v": b"new", "/t/out/more": b""}, OWN, OUT, 0) == ""


@pytest.mark.parametrize(
    ("after", "own", "code", "said"),
    [
        (BEFORE | {"/t/notes": b""}, OWN, 0, "lost /t/notes"),
        ({key: BEFORE[key] for key in BEFORE if key != "/t/link"}, OWN, 0, "lost /t/link"),
        (BEFORE | {"/t/out/core.v": b"new"}, {}, 0, "lost /t/out/core.v"),
        (BEFORE | {"/t/.tfra-0": None}, OWN, 0, "left /t/.tfra-0"),
        ({key: BEFORE[key] for key in BEFORE if "out" not in key}, OWN, 0, "no output"),
        (BEFORE | {"/t/out/core.v": b"new"}, OWN, 2, "changed in spite of exit code 2"),
    ],
)
def test_what_is_lost_or_left_is_told(after: trees.Tree, own: dict[str, bytes], code: int, said: str) -> None:
    assert trees.verdict(BEFORE, after, own, OUT, code) == said
