"""The blocks of a design in C, in dataflow order: one text a block, which C and C++ share."""

from importlib.resources import files

from tfra.codegen.blocks.constants import PARITIES
from tfra.model.fixed.coefficients import Stack
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign

_PRODUCTS = "products"
"""The functions of the stacks, which are made here."""

_SHARED = (
    "numbers",
    "normalize",
    "normaliser",
    "butterfly",
    "taxels",
    "matvec",
    _PRODUCTS,
    "combine",
    "cordic",
    "words",
    "gain",
)
_BLOCKS: dict[type[Design], tuple[str, ...]] = {
    TfraDesign: (
        "centroids", "weights", "dependent", "sweep", "friction", "resultant", "gain", "forces", "scaling", "estimate",
    ),
    LearnedDesign: ("activation", "resultant", "friction", "field", "share", "forces", "estimate"),
}  # fmt: skip
_OF_FORCES = ("normalize", "taxels", "combine", "field", "share", "forces")
"""Blocks of the learned estimator that only forces at the taxels need."""


def blocks(design: Design) -> dict[str, str]:
    """Texts by the names of the blocks; those of an estimator alone are in its folder."""
    names = [*_SHARED, *(f"{design.estimator}/{name}" for name in _BLOCKS[type(design)])]
    if "forces" not in design.result_fields:
        names = [name for name in names if name.rpartition("/")[2] not in _OF_FORCES]
    made = {_PRODUCTS: "\n".join(map(_product, design.stacks.values()))}
    return {name: made.get(name) or _source(name) for name in names}


def _source(name: str) -> str:
    return files("tfra.codegen.blocks").joinpath("source", f"{name}.c").read_text("utf-8")


def _product(stack: Stack) -> str:
    """A function of the stack's operand that gives the results of each of its operators."""
    count, bits, of = stack.operand_quads, f"OPERAND_{stack.name.upper()}", {n: name for name, n in PARITIES.items()}
    results = [f"vector_t {op.name}[4 * {op.quads}]" for op in stack.operators]
    calls = (
        f"    matvec({op.quads}, {count}, {op.name.upper()}, words, {of[op.flip]}, "
        f"FRACTION_{op.name.upper()} + {bits} - 1, needed, {op.name});"
        for op in stack.operators
    )
    return "\n".join(
        [
            f"// The products of stack {stack.name}.",
            "",
            f"static void product_{stack.name}(const vector_t x[4 * {count}],",
            ",\n".join(f"    {result}" for result in results) + ")",
            "{",
            f"    operand_t words[4 * {count}];",
            "    int needed[4];",
            f"    operands({count}, x, {bits}, words, needed);",
            *calls,
            "}",
            "",
        ]
    )
