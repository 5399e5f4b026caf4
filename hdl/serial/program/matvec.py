"""Matrix-vector products: operands of the lanes, and the program that runs in parallel with them."""

from tfra.hdl.serial import isa
from tfra.hdl.serial.isa import NOTHING, R0, R1, SUM, Dest, Op, Post, T, imm, mem
from tfra.hdl.serial.program.memory import bases, length, lengths, operator_of
from tfra.hdl.serial.program.routines import Writer

# Operands


def operand(w: Writer, vector: int, quads: int, words: int, significant: isa.Operand) -> None:
    """Each parity of a ``vector`` of ``quads`` as multiplier ``words``, and the four numbers of ``significant`` bits.

    Changes R0, R1, T, SH and pointers 0 to 3.
    """
    w.points(p0=vector, p1=vector, p2=words, p3=significant.immediate)
    w.call(normalise_parities, quads)


def normalise_parities(w: Writer, quads: int) -> None:
    """Body of :func:`operand`: P0 and P1 at the vector, P2 at the words, P3 at the numbers of bits."""
    a = w.assembler
    with a.loop(4):
        a.move(R0, imm(0))
        for _ in a.unrolled(quads):
            a.op(Op.OR, R0, R0, mem(0, 0, Post.UP))
        w.length(R1, R0)
        a.move(mem(0, 3, Post.UP), R1)
        a.sub(Dest.SH, R1, imm(w.operand - 1))
        with a.loop(quads):
            a.act(Op.SHIFT, mem(0, 1, Post.UP))
            a.op(Op.FIT, mem(0, 2, Post.UP), T, NOTHING)


# Products


def product(w: Writer, name: str, words: int, significant: isa.Operand, stride: int, wanted: int = 4) -> None:
    """Results of operator ``name`` for the operand ``words``, written from pointer 2 on, ``stride`` words for a parity.

    The ``wanted`` parities are the first ones: those after them are not computed.
    Changes R0, R1, T, SH, SP and pointers 0, 1, 2 and 5.
    """
    operator = operator_of(w.design, name)
    products = length(operator)
    sources = [parity ^ operator.flip for parity in range(4)]
    table = [word for source in sources for word in (words + source * products, significant.immediate + source)]
    w.assembler.move(Dest.SP, w.const(bases(w.design)[name]))
    w.points(p5=w.map.constants(*table))
    longest = (1 << (w.sizes.shift - 1)) - 1  # where more would be needed, all sums are rounded to zero
    w.assembler.move(R1, imm(min(operator.fraction + w.operand - 1, longest)))
    w.call(parities, stride, products, wanted)


def parities(w: Writer, quads: int, products: int, wanted: int) -> None:
    """Body of :func:`product`: ``quads`` results of each wanted parity, in groups of as many as there are lanes; each
    is a sum of ``products``.

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
    groups, late = -(-quads // lanes), products + isa.MAC_DELAY
    store = 2 * lanes
    read = min(isa.MAC_DELAY, late - store + 1)
    turn = max(products, late - read, read + store)
    start = isa.Instruction(Op.MAC, left=lengths(w.design).index(products), pointer=0)
    _next_parity(w)
    with a.loop(wanted):
        a.sub(Dest.SH, R1, mem(0, 1))
        a.emit(start)
        if groups > 1:
            # A loop begins with an instruction.  One iteration needs none, and nothing is stored before it.
            a.nop(turn - 2 if groups > 2 else max(products, late - read) - 1)
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
        w.assembler.move(isa.pointer(number), R0)


def _store_sums(w: Writer) -> None:
    """Round the sums of all lanes and store them at pointer 2."""
    for _ in range(w.sizes.lanes):
        w.round_shift(mem(0, 2, Post.UP), SUM)
