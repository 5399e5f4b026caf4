"""Intake of a frame's codes, with the moments of both zones (Eqs. 19-22)."""

from tfra.hdl.serial.isa import IN, NOTHING, R0, R1, R2, R3, R4, R5, ZERO, Op, Post, When, imm, mem
from tfra.hdl.serial.program.routines import extremes
from tfra.hdl.serial.program.tfra.memory import TfraWriter


def codes(w: TfraWriter) -> tuple[int, int, int]:
    """Store codes as they arrive, and add them up for both zones: compression (c) and traction (t) (Eqs. 19-22).

    ======  =================================================================================
    R1, R3  sums of the row so far: magnitudes of compression, codes of traction
    R2, R4  their running sums: the moments u_c and u_t
    R5      the largest code yet, its sign folded away; its bit length at the end
    F0      at the end: no code reaches the contact threshold
    ======  =================================================================================

    Returns the cycle that takes the last code, the cycles since the first one, and those from one code to the next of
    its row.
    """
    a, sensor = w.assembler, w.design.sensor
    for name in ("sum_c", "sum_t", "v_c", "v_t"):
        a.move(w.at(name), NOTHING)
    for register in (R1, R2, R3, R4, R5):
        a.move(register, imm(0))
    w.points(p0=w.map.stress)
    with a.loop(sensor.rows):
        with a.loop(sensor.columns):
            start = a.here
            _code(w)
            a.sign(0, R5, R0)
            a.move(R5, R0, When.F0)
            taxel, behind = a.here, a.here - start
        start = a.here
        _row(w)
        turn = a.here
        behind += turn - start
    taken = a.cycles - behind
    a.move(w.at("u_c"), R2)
    a.move(w.at("u_t"), R4)
    extremes(w)
    return taken, sensor.rows * turn - 1 - behind, taxel  # the first turn begins with the loop of its columns


def _code(w: TfraWriter) -> None:
    """One code: its sums, and R0 = its bits beside the sign."""
    a = w.assembler
    a.move(R0, IN)
    a.move(mem(0, 0, Post.UP), R0)
    a.op(Op.LESS, R1, R1, R0)
    a.add(R2, R2, R1)
    a.op(Op.PLUS, R3, R3, R0)
    a.add(R4, R4, R3)
    a.op(Op.OR, R0, ZERO, R0)


def _row(w: TfraWriter) -> None:
    """The end of a row: sums of the frame, and their running sums, the moments v_c and v_t."""
    a = w.assembler
    a.add(w.at("sum_c"), R1, w.at("sum_c"))
    a.add(w.at("sum_t"), R3, w.at("sum_t"))
    for zone in "ct":
        a.move(R0, w.at(f"sum_{zone}"))
        a.add(w.at(f"v_{zone}"), R0, w.at(f"v_{zone}"))
    a.move(R1, imm(0))
    a.move(R3, imm(0))
