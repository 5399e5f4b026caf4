"""Small wrong changes of a source file: another operator, constant, arm or handshake, a register left out."""

import ast
import random
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

OPERATORS: dict[type[ast.AST], Any] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
HANDSHAKE = {"valid": "ready", "ready": "valid"}
NAMES = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
DELAYS = ("register", "delayed")
"""Functions ``(m, value, ...)`` of :mod:`tfra.hdl.lib.pipeline` whose result is ``value``, later."""
LABELS = ("name", "src_loc_at", "stacklevel")
"""Keywords of arguments that change no result."""


@dataclass(frozen=True)
class Mutation:
    """``new`` in place of the bytes from ``start`` to ``end`` of a file, which are on ``line``."""

    kind: str
    line: int
    start: int
    end: int
    old: str
    new: str

    def apply(self, text: str) -> str:
        """The source ``text`` with this change."""
        data = text.encode()
        return (data[: self.start] + self.new.encode() + data[self.end :]).decode()


def mutations(text: str) -> list[Mutation]:
    """Every mutation of the source ``text``; the new expression is in brackets, so that no neighbour changes."""
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for node in _expressions(ast.parse(text)):
        for kind, new in _changes(node):
            end = starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
            start = starts[node.lineno - 1] + node.col_offset
            found.append(Mutation(kind, node.lineno, start, end, ast.unparse(node), f"({ast.unparse(new)})"))
    return found


def _expressions(node: ast.AST) -> Iterator[ast.expr]:
    """The expressions in ``node``, except in what only people, type checkers or the start of a script read."""
    match node:
        case ast.Raise() | ast.Assert() | ast.JoinedStr() | ast.Compare(left=ast.Name(id="__name__")):
            return
        case ast.keyword(arg=name) if name in LABELS:
            return
        case ast.FunctionDef(args=arguments, body=body):
            parts = [*arguments.defaults, *filter(None, arguments.kw_defaults), *body]
        case ast.ClassDef(body=body):
            parts = list(body)
        case ast.AnnAssign(value=value):
            parts = [value] if value else []
        case ast.Call(func=ast.Attribute(value=ast.Attribute(attr="valid" | "ready", value=stream), attr="eq")):
            parts = [stream, *node.args]
            yield node
        case _:
            parts = list(ast.iter_child_nodes(node))
            if isinstance(node, ast.expr):
                yield node
    for part in parts:
        yield from _expressions(part)


def _changes(node: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    """Kinds of changes of an expression, and what it becomes."""
    match node:
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS and _numbers(left, right):
            yield "operator", ast.BinOp(left, OPERATORS[type(op)](), right)
        case ast.BoolOp(op=op, values=values):
            yield "operator", ast.BoolOp(OPERATORS[type(op)](), values)
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in OPERATORS:
            yield "comparison", ast.Compare(left, [OPERATORS[type(op)]()], [right])
            if not isinstance(op, ast.Eq | ast.NotEq):
                yield "swapped comparison", ast.Compare(right, [op], [left])
        case ast.UnaryOp(op=ast.Invert() | ast.Not(), operand=operand):
            yield "negation dropped", operand
        case ast.Constant(value=int(value)) if not isinstance(value, bool):
            yield "constant", ast.Constant(value + 1)
            yield "constant", ast.Constant(abs(value - 1))
        case ast.IfExp(test=test, body=body, orelse=other):
            yield "swapped arms", ast.IfExp(test, other, body)
        case ast.Call(func=ast.Name(id="Mux") as mux, args=[test, body, other]):
            yield "swapped arms", ast.Call(mux, [test, other, body], node.keywords)
        case ast.Call(func=ast.Name(id=name), args=[_, value, *_]) if name in DELAYS:
            yield "delay dropped", value
        case ast.Name(id=name) if name in NAMES:
            yield "operator", ast.Name(NAMES[name])
        case ast.Attribute(value=value, attr=name, ctx=ast.Load()) if name in HANDSHAKE | NAMES:
            kind = "handshake" if name in HANDSHAKE else "operator"
            yield kind, ast.Attribute(value, (HANDSHAKE | NAMES)[name])
        case ast.Slice():  # its brackets would be no expression: its bounds change as expressions of their own
            return


def _numbers(*sides: ast.expr) -> bool:
    """Whether none of these is a text, a list or a union of types."""
    texts = (ast.JoinedStr, ast.Dict, ast.List, ast.Tuple, ast.ListComp)
    return not any(
        isinstance(side, texts) or (isinstance(side, ast.Constant) and not isinstance(side.value, int | float))
        for side in sides
    )


def choose(files: Iterable[tuple[str, str]], count: int, seed: int) -> list[tuple[str, Mutation]]:
    """``count`` mutations of ``files``, names and texts: one of every file, then a second of each, and so on.

    The kinds of a file's mutations take turns, since most places are constants.
    """
    rng, chosen = random.Random(seed), list[tuple[str, Mutation]]()
    waiting = {name: list(_in_turns(mutations(text), random.Random(f"{seed} {name}"))) for name, text in files}
    while len(chosen) < count and (left := [name for name, found in waiting.items() if found]):
        chosen += [(name, waiting[name].pop(0)) for name in rng.sample(left, len(left))]
    return chosen[:count]


def _in_turns(found: list[Mutation], rng: random.Random) -> Iterator[Mutation]:
    """The mutations in random order, a kind after another."""
    kinds: dict[str, list[Mutation]] = {}
    for mutation in rng.sample(found, len(found)):
        kinds.setdefault(mutation.kind, []).append(mutation)
    while kinds:
        for kind in rng.sample(sorted(kinds), len(kinds)):
            yield kinds[kind].pop()
            if not kinds[kind]:
                del kinds[kind]
