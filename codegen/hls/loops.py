"""The loops and calls of functions in C++: where pipelines are, and how many cycles they ask for.

Reads the generator's style: a function's braces are at the left edge, and what a statement governs is indented.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

_FUNCTION = re.compile(r"^(?:template <([^>]*)>\n)?(?:static )?\w+ (\w+)\(([^{;]*)\)\n\{\n(.*?)^\}", re.M | re.S)
_HEADER = re.compile(r"( *)(?:\} )?(for|while|do|if|else)\b ?(?:\((.*)\))?( if .*)?( \{)?$")
_CALL = re.compile(r"\b([a-z]\w*)(?:<([^<>]*)>)?\(")
_UP = re.compile(r"int (\w+) = (.+); \1 < (.+); \1\+\+$")
_HALVING = re.compile(r"int (\w+) = (.+); \1; \1 >>= 1$")
_PIPELINE = re.compile(r"#pragma HLS PIPELINE II=(\w+)")


@dataclass(frozen=True)
class Call:
    """A call of ``name`` with the expressions of its template's arguments."""

    name: str
    arguments: tuple[str, ...]


@dataclass
class Block:
    """What a function, a loop (``header``) or the ways of a choice have in them, and the pragmas of it itself."""

    header: str = ""
    parts: list["Block | Choice | Call"] = field(default_factory=list)
    pragmas: list[str] = field(default_factory=list)


@dataclass
class Choice:
    """Ways of which one is gone."""

    ways: list[Block] = field(default_factory=list)


@dataclass(frozen=True)
class Function:
    """The ``names`` of the counts that its template takes, its parameters as written, and its body."""

    names: tuple[str, ...]
    parameters: str
    body: Block


def functions(text: str) -> dict[str, Function]:
    """All functions of ``text`` by their names."""
    return {
        name: Function(
            tuple(part.split()[-1] for part in (counts or "").split(", ") if part),
            " ".join(parameters.split()),
            _parsed(Block(), body.splitlines()),
        )
        for counts, name, parameters, body in _FUNCTION.findall(text)
    }


def _parsed(block: Block, lines: list[str]) -> Block:
    place = 0
    while place < len(lines):
        line = lines[place]
        place += 1
        if found := _HEADER.match(line):
            inner = list(_deeper(lines[place:], len(found[1])))
            place += len(inner)
            _govern(block, found[2], found[3] or "", inner)
        elif "#pragma" in line:
            block.pragmas.append(line.strip())
        else:
            block.parts += [Call(name, tuple((of or "").split(", "))) for name, of in _CALL.findall(line)]
    return block


def _deeper(lines: list[str], indent: int) -> Iterator[str]:
    for line in lines:
        if line.strip() and len(line) - len(line.lstrip()) <= indent:
            return
        yield line


def _govern(block: Block, word: str, condition: str, inner: list[str]) -> None:
    """Add to ``block`` the lines ``inner`` under ``word``."""
    if word in ("for", "while", "do"):
        block.parts.append(_parsed(Block(condition or word), inner))
        return
    block.parts += [Call(name, tuple((of or "").split(", "))) for name, of in _CALL.findall(condition)]
    if word == "if":
        block.parts.append(Choice())
    choice = block.parts[-1]
    assert isinstance(choice, Choice)
    choice.ways.append(_parsed(Block(), inner))


def trips(header: str, values: Mapping[str, int]) -> int:
    """How often a loop runs; raises ``ValueError`` where constants and counts don't say it."""
    try:
        if up := _UP.match(header):
            return _value(up[3], values) - _value(up[2], values)
        if halving := _HALVING.match(header):
            return _value(halving[2], values).bit_length()
    except NameError as error:
        raise ValueError(f"loop ({header}): {error}") from None
    raise ValueError(f"loop ({header}): its bound is not constant")


def _value(expression: str, values: Mapping[str, int]) -> int:
    return int(eval(expression, {"__builtins__": {}}, dict(values)))


def cycles(
    name: str, among: Mapping[str, Function], values: Mapping[str, int], counts: tuple[int, ...] = (), each: int = 0
) -> int:
    """Iterations that the function ``name`` with the ``counts`` of its template has one after the other.

    A pipelined loop counts its iterations times their interval, one that is unrolled none, a choice its longest way;
    an iteration of a loop without a pragma counts what is in it, and ``each``.  Raises ``ValueError`` as :func:`trips`.
    """
    scope = dict(values) | dict(zip(among[name].names, counts, strict=True))

    def of(part: Block | Choice | Call) -> int:
        match part:
            case Call() if part.name in among:
                return cycles(part.name, among, values, tuple(_value(e, scope) for e in part.arguments if e), each)
            case Call():
                return 0
            case Choice():
                return max(map(of, part.ways))
        inside = sum(map(of, part.parts))
        if not part.header:
            return inside
        count = trips(part.header, scope)
        if any("UNROLL" in pragma for pragma in part.pragmas):
            return 0
        for pragma in part.pragmas:
            if found := _PIPELINE.search(pragma):
                return count * _value(found[1], scope)
        return count * (each + inside)

    return of(among[name].body)
