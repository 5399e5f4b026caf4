"""Mutations of a source file: each replaces one place of its text."""

from __future__ import annotations

import ast
import random
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

Span = tuple[int, int]
"""Bytes of a file from the first to after the last."""

OPERATORS: dict[type[ast.AST], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
    ast.LShift: ("<<", ">>"),
    ast.RShift: (">>", "<<"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.And: ("and", "or"),
    ast.Or: ("or", "and"),
}
"""Operators, and their replacements."""

NAMES = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
HANDSHAKE = {"valid": "ready", "ready": "valid"}
DELAYS = ("register", "delayed")
"""Functions ``(m, value, ...)`` of :mod:`tfra.hdl.lib.pipeline` whose result is ``value``, later."""

LABELS = ("name", "src_loc_at", "stacklevel")
"""Keywords of arguments that change no result."""


@dataclass(frozen=True)
class Mutation:
    """``new`` instead of the bytes ``span``, which belong to the node of the syntax tree at ``node``."""

    kind: str
    span: Span
    new: str
    node: Span

    def apply(self, text: str) -> str:
        """The source ``text`` with this change."""
        data = text.encode()
        return (data[: self.span[0]] + self.new.encode() + data[self.span[1] :]).decode()

    def line(self, text: str) -> int:
        """The number of its first line in ``text``."""
        return text.encode()[: self.span[0]].count(b"\n") + 1

    def before(self, text: str) -> str:
        """The lines of ``text`` that it changes, without indentation."""
        return _lines(text, self.span)

    def after(self, text: str) -> str:
        """What these lines become."""
        return _lines(self.apply(text), (self.span[0], self.span[0] + len(self.new.encode())))


def _lines(text: str, span: Span) -> str:
    data = text.encode()
    start, end = data.rfind(b"\n", 0, span[0]) + 1, data.find(b"\n", span[1])
    return " ".join(data[start : end if end >= 0 else len(data)].decode().split())


class _Places(ast.NodeVisitor):
    """Collects all mutations of a file, except in parts that only people or type checkers read."""

    def __init__(self, text: str) -> None:
        self.found: list[Mutation] = []
        self._data = text.encode()
        self._starts = [0]
        for line in self._data.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))

    def span(self, node: ast.AST) -> Span:
        """Where the expression ``node`` stands."""
        assert isinstance(node, ast.expr)
        end = self._starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
        return self._starts[node.lineno - 1] + node.col_offset, end

    def _text(self, span: Span) -> str:
        return self._data[slice(*span)].decode()

    def _add(self, kind: str, node: ast.AST, new: str, span: Span | None = None) -> None:
        place = self.span(node)
        self.found.append(Mutation(kind, span or place, new, place))

    def _operator(self, kind: str, node: ast.AST, operator: ast.AST, left: ast.AST, right: ast.AST) -> None:
        """Another operator between ``left`` and ``right``."""
        if type(operator) not in OPERATORS:
            return
        old, new = OPERATORS[type(operator)]
        start = self._data.index(old.encode(), self.span(left)[1], self.span(right)[0])
        self._add(kind, node, new, (start, start + len(old)))

    def _swap(self, kind: str, node: ast.AST, first: ast.AST, second: ast.AST) -> None:
        """``first`` and ``second`` in each other's place."""
        a, b = self.span(first), self.span(second)
        gap = self._text((a[1], b[0]))
        self._add(kind, node, f"({self._text(b)}){gap}({self._text(a)})", (a[0], b[1]))

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        for part in [*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None), *node.body]:
            self.visit(part)

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        for part in node.body:
            self.visit(part)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_Raise(self, node: ast.Raise) -> None:
        """Texts of errors stay."""

    def visit_Assert(self, node: ast.Assert) -> None:
        """Assertions stay."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Texts and names stay."""

    def visit_keyword(self, node: ast.keyword) -> None:
        if node.arg not in LABELS:
            self.visit(node.value)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not any(_is_no_number(side) for side in (node.left, node.right)):
            self._operator("operator", node, node.op, node.left, node.right)
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        if len(node.values) == 2:
            self._operator("operator", node, node.op, *node.values)
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        sides = [node.left, *node.comparators]
        for operator, left, right in zip(node.ops, sides, sides[1:], strict=False):
            self._operator("comparison", node, operator, left, right)
        if len(node.ops) == 1 and isinstance(node.ops[0], ast.Lt | ast.LtE | ast.Gt | ast.GtE):
            self._swap("swapped comparison", node, *sides)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.Invert | ast.Not):
            self._add("negation dropped", node, f"({self._text(self.span(node.operand))})")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if type(node.value) is int:
            for value in {node.value + 1, abs(node.value - 1)}:
                self._add("constant", node, str(value))

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self._swap("swapped arms", node, node.body, node.orelse)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
        if name == "Mux" and len(node.args) == 3:
            self._swap("swapped arms", node, *node.args[1:])
        if name in NAMES:
            end = self.span(node.func)[1]
            self._add("operator", node, NAMES[name], (end - len(name), end))
        if name in DELAYS and isinstance(node.func, ast.Name) and len(node.args) > 1:
            self._add("delay dropped", node, f"({self._text(self.span(node.args[1]))})")
        assigns = isinstance(node.func, ast.Attribute) and name == "eq"
        if isinstance(node.func, ast.Attribute) and not (assigns and _is_handshake(node.func.value)):
            self.visit(node.func.value)
        for part in [*node.args, *node.keywords]:
            self.visit(part)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if _is_handshake(node) and isinstance(node.ctx, ast.Load):
            end = self.span(node)[1]
            self._add("handshake", node, HANDSHAKE[node.attr], (end - len(node.attr), end))
        self.generic_visit(node)

    def visit_Slice(self, node: ast.Slice) -> None:
        for bound, sign in ((node.lower, "+"), (node.upper, "-")):
            if bound is not None and not isinstance(bound, ast.Constant):
                self._add("slice", bound, f"({self._text(self.span(bound))}) {sign} 1")
        self.generic_visit(node)


def _is_handshake(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and node.attr in HANDSHAKE


def _is_no_number(node: ast.AST) -> bool:
    """Texts, sets of keys and unions of types."""
    other = isinstance(node, ast.Constant) and not isinstance(node.value, int | float)
    return other or isinstance(node, ast.JoinedStr | ast.Dict | ast.List | ast.Tuple | ast.ListComp)


def mutations(text: str) -> list[Mutation]:
    """Every mutation of the source ``text``, in the order of its lines."""
    places = _Places(text)
    places.visit(ast.parse(text))
    return sorted(places.found, key=lambda m: (m.span, m.new))


def changed(before: ast.AST, after: ast.AST) -> ast.AST | None:
    """The smallest part of the tree ``before`` that holds all that ``after`` has different; None if they are equal."""
    if type(before) is not type(after):
        return before
    found: list[ast.AST] = []
    for old, new in zip(ast.iter_fields(before), ast.iter_fields(after), strict=True):
        olds, news = (part if isinstance(part, list) else [part] for part in (old[1], new[1]))
        if len(olds) != len(news):
            return before
        for one, other in zip(olds, news, strict=True):
            if not isinstance(one, ast.AST) or not isinstance(other, ast.AST):
                found += [before] if one != other or type(one) is not type(other) else []
            elif (part := changed(one, other)) is not None:
                found.append(part if isinstance(part, ast.expr | ast.stmt) else before)
    return found[0] if len(found) == 1 else before if found else None


def is_exact(text: str, mutation: Mutation) -> bool:
    """Whether the mutation changes its node of the tree alone: brackets that are missing would change others."""
    try:
        part = changed(ast.parse(text), ast.parse(mutation.apply(text)))
    except SyntaxError:
        return False
    span = _Places(text).span
    return isinstance(part, ast.expr) and mutation.node[0] <= span(part)[0] and span(part)[1] <= mutation.node[1]


def choose(files: Iterable[tuple[str, str]], count: int, seed: int) -> list[tuple[str, Mutation]]:
    """``count`` mutations of ``files``, names and texts: one of every file, then a second of each, and so on.

    The kinds of a file's mutations take turns, since most places are constants.
    """
    waiting = {name: _shuffled(text, random.Random(f"{seed} {name}")) for name, text in files}
    order, chosen = random.Random(seed), list[tuple[str, Mutation]]()
    while waiting and len(chosen) < count:
        for name in order.sample(list(waiting), len(waiting)):
            mutation = next(waiting[name], None)
            if mutation is None:
                del waiting[name]
            else:
                chosen.append((name, mutation))
    return chosen[:count]


def _shuffled(text: str, rng: random.Random) -> Iterator[Mutation]:
    """The mutations of ``text``, a kind after another in turns."""
    kinds: dict[str, list[Mutation]] = {}
    for mutation in mutations(text):
        kinds.setdefault(mutation.kind, []).append(mutation)
    for found in kinds.values():
        rng.shuffle(found)
    while kinds:
        for kind in rng.sample(sorted(kinds), len(kinds)):
            while kinds[kind] and not is_exact(text, kinds[kind][-1]):
                kinds[kind].pop()
            if kinds[kind]:
                yield kinds[kind].pop()
            else:
                del kinds[kind]
