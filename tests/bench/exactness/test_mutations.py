"""A mutation changes one place of a file, no text that only people read, and the same one for the same seed."""

from __future__ import annotations

import ast
import tokenize
from collections import Counter
from io import BytesIO

import pytest

from bench.exactness.mutants import sources
from bench.exactness.mutations import choose, is_exact, mutations
from bench.publish import ROOT


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("a = b + c", ["a = b - c"]),
        ("a = b - c  # b - c", ["a = b + c  # b - c"]),
        ("a = (b) & (c | d)", ["a = (b) & (c & d)", "a = (b) | (c | d)"]),
        ("a = b << c", ["a = b >> c"]),
        ("a = b == c", ["a = b != c"]),
        ("a = b < c", ["a = (c) < (b)", "a = b <= c"]),
        ("a = 7", ["a = 6", "a = 8"]),
        ("a = 0", ["a = 1"]),
        ("a = ~b", ["a = (b)"]),
        ("a = not b", ["a = (b)"]),
        ("a = Mux(b, c, d)", ["a = Mux(b, (d), (c))"]),
        ("a = b if c else d", ["a = (d) if c else (b)"]),
        ("a = register(m, b, 'b')", ["a = (b)"]),
        ("a = delayed(m, b & c, n)", ["a = (b & c)", "a = delayed(m, b | c, n)"]),
        ("a = np.minimum(b, c)", ["a = np.maximum(b, c)"]),
        ("a.eq(b.valid)", ["a.eq(b.ready)"]),
        ("a.valid.eq(b)", []),
        ("a = b[c:]", ["a = b[(c) + 1:]"]),
        ("a = b[:c]", ["a = b[:(c) - 1]"]),
        ("a = b and c", ["a = b or c"]),
    ],
)
def test_operators(text, changed):
    assert sorted(mutation.apply(text) for mutation in mutations(text)) == sorted(changed)
    assert all(is_exact(text, mutation) for mutation in mutations(text))


@pytest.mark.parametrize(
    "text",
    [
        '"""1 + 1"""',
        "def f(a: Literal[1] | None = None) -> int | None: ...",
        "a: int | None = None",
        "raise ValueError(a + 1)",
        "assert a == 1",
        "a = Signal(name='a' + str(1))",
        "a = f'{b + 1}'",
        "a = 'b' + c",
        "from a import b",
    ],
)
def test_what_only_people_read_stays(text):
    assert mutations(text) == []


def test_a_change_of_its_neighbours_is_no_mutation():
    text = "a = b ^ c & d"
    (mutation,) = mutations(text)
    assert mutation.apply(text) == "a = b ^ c | d"  # which is (b ^ c) | d
    assert not is_exact(text, mutation)


CHOSEN = choose(sources(""), 200, seed=3)


def test_one_place_of_each_file_is_another():
    texts = dict(sources(""))
    for name, mutation in CHOSEN:
        before, after = texts[name], mutation.apply(texts[name])
        assert ast.dump(ast.parse(before)) != ast.dump(ast.parse(after))
        old, new = tokens(before), tokens(after)
        inside = len(tokens(before.encode()[slice(*mutation.span)].decode()))
        start = next(number for number, pair in enumerate(zip(old, new, strict=False)) if pair[0] != pair[1])
        end = next(number for number, pair in enumerate(zip(old[::-1], new[::-1], strict=False)) if pair[0] != pair[1])
        assert len(old) - start - end <= inside, (name, mutation)
        assert mutation.before(before) != mutation.after(before)


def tokens(text):
    """Words and signs of a source, or of a part of one, without its layout."""
    found = []
    for token in tokenize.tokenize(BytesIO(f"(\n{text}\n)".encode()).readline):
        if token.type in (tokenize.NAME, tokenize.NUMBER, tokenize.OP, tokenize.STRING):
            found.append(token.string)
    return found[1:-1]


def test_a_seed_chooses_the_same_mutants_again():
    few = sources("")[::8]
    chosen = choose(few, 30, seed=3)
    assert choose(few, 30, seed=3) == chosen
    assert choose(few, 30, seed=4) != chosen
    assert choose(few, 10, seed=3) == chosen[:10]


def test_every_file_has_its_share():
    counts = Counter(name for name, _ in CHOSEN)
    able = [name for name, text in sources("") if mutations(text)]
    assert set(counts) == set(able)
    assert max(counts.values()) <= -(-200 // len(able)) + 1
    assert all((ROOT / name).is_file() for name in counts)
