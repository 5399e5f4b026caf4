"""AXI4-Lite: the bus, the port of registers, and the subordinate between them (AMBA IHI 0022, part B)."""

from typing import Any

from amaranth import Cat, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS, BYTES
from tfra.hdl.lib.pipeline import delayed

ANSWER = 3
"""Cycles from an access of a register port to its answer."""


def bus(address_bits: int) -> wiring.Signature:
    """AXI4-Lite as its manager drives it, with the standard's names; ``prot`` is there for it, and nobody reads it."""
    request = {"addr": address_bits, "prot": 3}
    channels: dict[str, tuple[Any, dict[str, int]]] = {
        "aw": (Out, request),
        "w": (Out, {"data": BITS, "strb": BYTES}),
        "b": (In, {"resp": 2}),
        "ar": (Out, request),
        "r": (In, {"data": BITS, "resp": 2}),
    }
    members: dict[str, Any] = {}
    for name, (flow, words) in channels.items():
        members |= {f"{name}{key}": flow(bits) for key, bits in {**words, "valid": 1}.items()}
        members[f"{name}ready"] = flow.flip()(1)
    return wiring.Signature(members)


def register_port(address_bits: int) -> wiring.Signature:
    """The port of registers as its user drives it.

    ``read`` or ``write`` is high for one cycle, or both are.  ``answer`` and ``read_error``, or ``write_error``, are
    there ``ANSWER`` cycles later, and stay until the next access of that kind is answered.
    """
    return wiring.Signature({
        "read_address": Out(address_bits),  # of a byte; its low bits have no meaning
        "read": Out(1),
        "answer": In(BITS),
        "read_error": In(1),
        "write_address": Out(address_bits),
        "write": Out(1),
        "data": Out(BITS),  # the word to write ...
        "strobe": Out(BYTES),  # ... and which of its bytes
        "write_error": In(1),
    })


class AxiLite(wiring.Component):
    """Turn the accesses of an AXI4-Lite bus into those of a register port.

    One write and one read may be outstanding.  Address and data of a write come in any order.  An error of the
    registers is answered with SLVERR.  Every output to the bus is a register, so no ready leads to a valid.

    ``latency`` counts cycles from the transfer that completes a request to the valid of its answer.  ``interval``
    counts cycles between requests of a kind whose answers are taken at once.
    """

    latency = 1 + ANSWER
    interval = 2 + ANSWER

    def __init__(self, address_bits: int) -> None:
        super().__init__({"bus": In(bus(address_bits)), "port": Out(register_port(address_bits))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bus, port = self.bus, self.port
        write_address, write_waits = self._request(m, "aw", ("addr",), port.write, "b")
        word, word_waits = self._request(m, "w", ("data", "strb"), port.write, "b")
        read_address, read_waits = self._request(m, "ar", ("addr",), port.read, "r")
        m.d.comb += [
            port.write.eq(write_waits & word_waits),
            port.write_address.eq(write_address),
            port.read.eq(read_waits),
            port.read_address.eq(read_address),
            Cat(port.data, port.strobe).eq(word),
            bus.rdata.eq(port.answer),
            bus.rresp.eq(port.read_error << 1),
            bus.bresp.eq(port.write_error << 1),
        ]
        self._answer(m, "b", port.write)
        self._answer(m, "r", port.read)
        return m

    def _request(
        self, m: Module, channel: str, words: tuple[str, ...], access: Value, answer: str
    ) -> tuple[Value, Value]:
        """A transfer of ``channel``, and whether it waits for its ``access``.

        The channel is not ready again until the ``answer`` has been taken.
        """
        payload = Cat(getattr(self.bus, f"{channel}{word}") for word in words)
        valid, ready = (getattr(self.bus, f"{channel}{name}") for name in ("valid", "ready"))
        request = Signal(len(payload), name=f"{channel}_request", reset_less=True)
        free = Signal(init=1, name=f"{channel}_free")
        waits = Signal(name=f"{channel}_waits")
        m.d.comb += ready.eq(free)
        with m.If(free):
            m.d.sync += [
                request.eq(payload),
                waits.eq(valid),
                free.eq(~valid),
            ]
        with m.If(access):
            m.d.sync += waits.eq(0)
        with m.If(self._taken(answer)):
            m.d.sync += free.eq(1)
        return request, waits

    def _answer(self, m: Module, channel: str, access: Value) -> None:
        """Be valid when the registers have answered the ``access``."""
        valid = getattr(self.bus, f"{channel}valid")
        with m.If(delayed(m, access, ANSWER - 1, f"{channel}_access", control=True)):
            m.d.sync += valid.eq(1)
        with m.Elif(self._taken(channel)):
            m.d.sync += valid.eq(0)

    def _taken(self, channel: str) -> Value:
        return getattr(self.bus, f"{channel}valid") & getattr(self.bus, f"{channel}ready")
