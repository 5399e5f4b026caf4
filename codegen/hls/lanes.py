"""Multipliers of the products in an HLS core: the lanes of the architecture, shared among all operators."""

from collections import defaultdict

from tfra.codegen.blocks.program import blocks
from tfra.model.fixed.design import Design


def lanes(design: Design) -> dict[str, int]:
    """Multipliers by the names of the operators, each a divisor of its rows' length: a row is a whole number of words.

    One each, then more where a stack takes longest, as long as all are at most ``mac_lanes``.  Stacks work on different
    frames at a time, and so share none.
    """
    text = "".join(blocks(design).values())
    rows = {op.name: stack.operand_quads for stack in design.stacks.values() for op in stack.operators}
    found = dict.fromkeys(rows, 1)
    products: dict[str, dict[str, int]] = defaultdict(dict)
    for stack in design.stacks.values():
        calls = text.count(f"product_{stack.name}(") - 1
        for op in stack.operators:
            products[stack.name][op.name] = calls * op.rows.size

    def slowest() -> str:
        busy = max(products.values(), key=lambda ops: sum(n / found[op] for op, n in ops.items()))
        return max(busy, key=lambda op: busy[op] / found[op])

    while found[name := slowest()] < rows[name]:
        more = next(n for n in range(found[name] + 1, rows[name] + 1) if rows[name] % n == 0)
        if sum(found.values()) - found[name] + more > design.architecture.mac_lanes:
            break
        found[name] = more
    return found


def lane_constants(design: Design) -> dict[str, int]:
    """Constants that the pragmas name: lanes of operators and cycles of their rows, and the most lanes of a stack."""
    found, constants = lanes(design), {}
    for stack in design.stacks.values():
        constants[f"WORDS_{stack.name.upper()}"] = max(found[op.name] for op in stack.operators)
        for op in stack.operators:
            constants[f"LANES_{op.name.upper()}"] = found[op.name]
            constants[f"REUSE_{op.name.upper()}"] = stack.operand_quads // found[op.name]
    return constants
