"""Matrix-vector products: operands of the lanes, and the program that runs in parallel with them (Eqs. 6, 9, 10)."""

from __future__ import annotations

from tfra.hdl.serial.isa import (
    MAC_DELAY,
    NOTHING,
    R0,
    R1,
    SUM,
    Dest,
    Instruction,
    Op,
    Operand,
    Post,
    T,
    When,
    imm,
    mem,
    pointer,
)
from tfra.hdl.serial.program.memory import bases, operator_of, stride
from tfra.hdl.serial.program.routines import Writer

# Stages


def contact(w: Writer) -> None:
    """C33^-1 b, and the sums of A-dagger b."""
    bits = w.at("bits", 4)
    operand(w, w.map.d, w.map.operand, bits)
    w.points(p2=w.map.result)
    product(w, "c33_inv", w.map.operand, bits)
    w.points(p2=w.map.sums_b)
    product(w, "sums_b", w.map.operand, bits)


def residual(w: Writer) -> None:
    """g = C33 n; -C31 n and -C32 n by their roles in the sweep; the other sums; d = b + g."""
    a, places, bits = w.assembler, w.map, w.at("bits_n", 4)
    w.points(p2=places.g)
    product(w, "c33", places.weights, bits)
    w.set_flag(0, w.at("sweep_y"))
    for name, dependent, independent in (("c31", When.F0, When.NOT_F0), ("c32", When.NOT_F0, When.F0)):
        a.move(pointer(2), w.address(places.dependent), dependent)
        a.move(pointer(2), w.address(places.independent), independent)
        product(w, name, places.weights, bits)
    w.points(p2=places.sums_n)
    product(w, "sums_n", places.weights, bits)
    w.points(p0=0)
    with a.loop(4 * w.quads):
        a.move(R0, mem(places.g, 0))
        a.add(mem(places.d, 0, Post.UP), R0, mem(places.d, 0, Post.UP))


def normal(w: Writer) -> None:
    """C33 A-dagger_3 of e0, and of e1."""
    places, bits = w.map, w.at("bits", 4)
    for vector, result in ((places.d, places.result), (places.independent, places.dependent)):
        operand(w, vector, places.operand, bits)
        w.points(p2=result)
        product(w, "normal", places.operand, bits)


# Operands


def operand(w: Writer, vector: int, words: int, significant: Operand) -> None:
    """Each parity of ``vector`` as multiplier ``words``, and the four numbers of ``significant`` bits.

    Changes R0, R1, T, SH and pointers 0 to 3.
    """
    w.points(p0=vector, p1=vector, p2=words, p3=significant.immediate)
    w.call(normalise_parities)


def normalise_parities(w: Writer) -> None:
    """Body of :func:`operand`: P0 and P1 at the vector, P2 at the words, P3 at the numbers of bits."""
    a = w.assembler
    with a.loop(4):
        a.move(R0, imm(0))
        for _ in a.unrolled(w.quads):
            a.op(Op.OR, R0, R0, mem(0, 0, Post.UP))
        w.length(R1, R0)
        a.move(mem(0, 3, Post.UP), R1)
        a.sub(Dest.SH, R1, imm(w.operand - 1))
        with a.loop(w.quads):
            a.act(Op.SHIFT, mem(0, 1, Post.UP))
            a.op(Op.FIT, mem(0, 2, Post.UP), T, NOTHING)


# Products


def product(w: Writer, name: str, words: int, significant: Operand) -> None:
    """Results of operator ``name`` for the operand ``words``, written from pointer 2 on.

    Changes R0, R1, T, SH, SP and pointers 0, 1, 2 and 5.
    """
    operator = operator_of(w.design, name)
    sources = [parity ^ operator.flip for parity in range(4)]
    table = [word for source in sources for word in (words + source * w.quads, significant.immediate + source)]
    w.assembler.move(Dest.SP, w.const(bases(w.design)[name]))
    w.points(p5=w.map.constants(*table))
    w.assembler.move(R1, imm(operator.fraction + w.operand - 1))
    w.call(parities, stride(w.design, operator))


def parities(w: Writer, quads: int) -> None:
    """Body of :func:`product`: ``quads`` results of each parity, in groups of as many as there are lanes.

    The program and the lanes work in parallel, and each group takes ``turn`` cycles:

    ===================  ===============================================================================
    cycle of the turn    program
    ===================  ===============================================================================
    0                    starts the group
    1 ... read - 1       waits: the lanes move the sums of the group before to where they can be read
    read ...             rounds and stores those sums, two instructions a lane
    ``turn`` - 1         waits for the end of the group
    ===================  ===============================================================================

    The sums of a group are ready ``late`` cycles after its start; those of a parity's last group are stored after
    the turns, and the next parity's pointers are set while that group runs.
    """
    a, lanes = w.assembler, w.sizes.lanes
    groups, late = -(-quads // lanes), w.quads + MAC_DELAY
    store = 2 * lanes
    read = min(MAC_DELAY, late - store + 1)
    turn = max(w.quads, late - read, read + store)
    start = Instruction(Op.MAC, pointer=0)
    _next_parity(w)
    with a.loop(4):
        a.sub(Dest.SH, R1, mem(0, 1))
        a.emit(start)
        if groups > 1:
            a.nop(turn - 2)
            with a.loop(groups - 1):
                a.emit(start)
                a.nop(read - 1)
                _store_sums(w)
                a.nop(turn - read - store)
        before = a.here
        _next_parity(w)
        wait = late - turn if groups > 1 else late - 1
        a.nop(max(0, wait - (a.here - before)))
        _store_sums(w)
        if groups * lanes > quads:  # results of lanes without a quad are overwritten
            a.advance(2, quads - groups * lanes)


def _next_parity(w: Writer) -> None:
    """Pointers 0 and 1, at the operand and at its number of bits, from the table at pointer 5."""
    for number in range(2):
        w.assembler.move(R0, mem(0, 5, Post.UP))
        w.assembler.move(pointer(number), R0)


def _store_sums(w: Writer) -> None:
    """Round the sums of all lanes and store them at pointer 2."""
    for _ in range(w.sizes.lanes):
        w.round_shift(mem(0, 2, Post.UP), SUM)
