"""A mutation changes one place of a file, no text that only people read, and the same one for the same seed."""

import ast
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from bench.publish import ROOT
from bench.scorecard.mutants.mutations import choose, mutations
from bench.scorecard.mutants.python import Copy, nearest, sources


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("a = b - c  # b - c", ["a = (b + c)  # b - c"]),
        ("a = b & (c | d)", ["a = (b | (c | d))", "a = b & ((c & d))"]),
        ("a = b < c", ["a = (b <= c)", "a = (c < b)"]),
        ("a = b == c", ["a = (b != c)"]),
        ("a = 7", ["a = (6)", "a = (8)"]),
        ("a = not b", ["a = (b)"]),
        ("a = Mux(b, c, d)", ["a = (Mux(b, d, c))"]),
        ("a = b if c else d", ["a = (d if c else b)"]),
        ("a = register(m, b, 'b')", ["a = (b)"]),
        ("a = delayed(m, b & c, n)", ["a = (b & c)", "a = delayed(m, (b | c), n)"]),
        ("a = np.minimum(b, c)", ["a = (np.maximum)(b, c)"]),
        ("a.eq(b.valid)", ["a.eq((b.ready))"]),
        ("a.valid.eq(b)", []),
        ("a = b and c", ["a = (b or c)"]),
        ('"""1 + 1"""', []),
        ("def f(a: Literal[1] | None = None) -> int | None: ...", []),
        ("raise ValueError(a + 1)", []),
        ("if __name__ == '__main__':\n    main()", []),
        ("assert a == 1", []),
        ("a = Signal(name='a' + str(1))", []),
        ("a = f'{b + 1}'", []),
        ("a = 'b' + c", []),
    ],
)
def test_changes(text: str, changed: list[str]) -> None:
    assert sorted(mutation.apply(text) for mutation in mutations(text)) == sorted(changed)


@pytest.mark.long
def test_every_file_has_its_share_of_other_programs() -> None:
    files = dict(sources())
    chosen = choose(files.items(), 200, seed=3)
    counts = Counter(name for name, _ in chosen)
    able = [name for name, text in files.items() if mutations(text)]
    assert set(counts) == set(able)
    assert max(counts.values()) <= -(-200 // len(able)) + 1
    for name, mutation in chosen:
        assert ast.dump(ast.parse(files[name])) != ast.dump(ast.parse(mutation.apply(files[name])))


def test_a_seed_chooses_the_same_mutants_again() -> None:
    few = sources()[::8]
    chosen = choose(few, 30, seed=3)
    assert choose(few, 30, seed=3) == chosen != choose(few, 30, seed=4)
    assert choose(few, 10, seed=3) == chosen[:10]


def test_nearest_tests_come_first() -> None:
    found = nearest("model/fixed/words.py", ROOT)
    assert found[0] == "tests/model/fixed/test_words.py"
    users = [name for name in found if "model.fixed.words" in (ROOT / name).read_text()]
    assert found[1 : len(users)] == users[1:] != []
    assert "tests/model/fixed/test_numbers.py" in found[len(users) :]
    assert all((ROOT / name).exists() for name in found)


@pytest.mark.long
def test_a_mutant_is_noticed_and_one_that_changes_nothing_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, test = "model/fixed/numbers.py", "tests/model/fixed/test_numbers.py"
    monkeypatch.setattr("bench.scorecard.mutants.python.nearest", lambda file, root: [test])
    copy, found = Copy(tmp_path), mutations((ROOT / file).read_text())
    wrong = next(mutation for mutation in found if mutation.kind == "operator")
    assert copy.judge(file, wrong).startswith(test)
    assert copy.judge(file, replace(wrong, new=f"({wrong.old})")) == ""
