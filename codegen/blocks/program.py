"""The blocks of a design in dataflow order: one text a block, which C and C++ share."""

from importlib.resources import files

from tfra.codegen.blocks.constants import PARITIES, constants
from tfra.codegen.blocks.dialect import resolved
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
    """Texts, in both languages of :mod:`.dialect`, by the names of the blocks; an estimator's own are in its folder."""
    names = [*_SHARED, *(f"{design.estimator}/{name}" for name in _BLOCKS[type(design)])]
    if "forces" not in design.result_fields:
        names = [name for name in names if name.rpartition("/")[2] not in _OF_FORCES]
    made = {_PRODUCTS: "\n".join(map(_product, design.stacks.values()))}
    true = {name for section in constants(design).values() for name, value in section.items() if value}
    return {name: resolved(made.get(name) or _source(name), true) for name in names}


def _source(name: str) -> str:
    return files("tfra.codegen.blocks").joinpath("source", f"{name}.c").read_text("utf-8")


def _product(stack: Stack) -> str:
    """A function of the stack's operand that gives the results of each of its operators."""
    count, of, name = stack.operand_quads, {n: parity for parity, n in PARITIES.items()}, stack.name.upper()
    lines = [
        f"// The products of stack {stack.name}.",
        "",
        f"static void product_{stack.name}(const vector_t x[4 * {count}],",
        ",\n".join(f"    vector_t {op.name}[4 * {op.quads}]" for op in stack.operators) + ")",
        "{",
        *(
            f"    //+ #pragma HLS {pragma}"
            for op in stack.operators
            for pragma in (
                f"ARRAY_RESHAPE variable={op.name.upper()} cyclic factor=LANES_{op.name.upper()}",
                f"BIND_STORAGE variable={op.name.upper()} type=rom_1p",
            )
        ),
        f"    operand_t words[4 * {count}];",
        f"    //+ #pragma HLS ARRAY_RESHAPE variable=words cyclic factor=WORDS_{name}",
        "    int needed[4];",
        f"    operands({count}, x, OPERAND_{name}, words, needed);",
        *(
            f"    matvec({op.quads}, {count}, {op.name.upper()}, words, {of[op.flip]}, "
            f"FRACTION_{op.name.upper()} + OPERAND_{name} - 1, needed, {op.name});"
            for op in stack.operators
        ),
        "}",
    ]
    return "\n".join(lines) + "\n"
