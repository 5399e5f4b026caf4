"""The registers of a map: what software accesses by AXI4-Lite, and hardware by a port for each field."""

from collections.abc import Collection, Mapping
from functools import reduce
from operator import or_
from typing import Any

from amaranth import Cat, Const, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.axi_lite import ANSWER, AxiLite, bus
from tfra.hdl.bus.map import BITS, BYTES, Field, Kind, Register, RegisterMap
from tfra.hdl.lib import pipeline

_WORD = (BYTES - 1).bit_length()
"""The lowest bit of a byte address that tells registers apart."""
_GROUP = 8
"""Registers whose words become one in the second step of a read."""


def hardware_ports(field: Field) -> dict[str, Any]:
    """Ports of ``field`` by name; :class:`Registers` drives those that are ``Out``.

    ========  ==========================================================================================
    status    ``NAME``: in, the word that software reads
    setting   ``NAME``: out
    pulse     ``NAME``: out, high for a cycle
    port      ``NAME``: out, and ``NAME_written``: out, high for a cycle, with the first one of a new word
    event     ``NAME_set``: in
    counter   ``NAME_up``: in, counts this cycle
    captured  ``NAME``: in, stored while ``NAME_store``, in, is high
    ========  ==========================================================================================
    """
    name, bits = field.name, field.bits
    return {
        Kind.CONSTANT: {},
        Kind.STATUS: {name: In(bits)},
        Kind.SETTING: {name: Out(bits, init=field.reset)},
        Kind.PULSE: {name: Out(bits)},
        Kind.PORT: {name: Out(bits), f"{name}_written": Out(1)},
        Kind.EVENT: {f"{name}_set": In(bits)},
        Kind.COUNTER: {f"{name}_up": In(1)},
        Kind.CAPTURED: {name: In(bits), f"{name}_store": In(1)},
    }[field.kind]


def hardware(registers: RegisterMap) -> wiring.Signature:
    """The side of the hardware, as :class:`Registers` drives it: by register, the ports of its fields."""
    ports = {
        register.name: {name: port for field in register.fields for name, port in hardware_ports(field).items()}
        for register in registers.registers
    }
    return wiring.Signature({name: Out(wiring.Signature(members)) for name, members in ports.items() if members})


class Registers(wiring.Component):
    """Fields of every kind; a write is carried out in the cycle after it, and accesses are answered after ``ANSWER``.

    Of an event that is set and cleared in one cycle the set wins; a counter that is cleared and counted is 1.  An
    unmapped address, a read of a register that software can only write, and the reverse are errors: they change nothing
    and read as 0.
    """

    def __init__(self, registers: RegisterMap) -> None:
        self._map = registers
        self._axi_lite = AxiLite(registers.address_bits)
        super().__init__({
            "bus": In(bus(registers.address_bits)),  # of software
            "hardware": Out(hardware(registers)),
            "interrupt": Out(1),  # level: an event and its enable were high a cycle before
        })
        self._port = self._axi_lite.port

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.axi_lite = self._axi_lite
        connect(m, flipped(self.bus), self._axi_lite.bus)
        fields = [(register, field) for register in self._map.registers for field in register.fields]
        values = {f"{register.name}.{field.name}": self._value(register, field) for register, field in fields}
        number = self._port.write_address[_WORD:]
        written = {
            register.name: pipeline.register(
                m, self._port.write & (number == register.address >> _WORD), f"{register.name}_written", control=True
            )
            for register in self._map.registers
            if register.writable
        }
        for register, field in fields:
            own = values[f"{register.name}.{field.name}"]
            if field.kind.writable:
                self._writable(m, register, field, own, written[register.name])
            if field.kind is Kind.COUNTER:
                clear = values[field.clear] if field.clear else Const(0)
                up = self._hardware(register, f"{field.name}_up")
                m.d.sync += own.eq(own + up)
                with m.If(clear):
                    m.d.sync += own.eq(up)
            if field.kind is Kind.CAPTURED:
                with m.If(self._hardware(register, f"{field.name}_store")):
                    m.d.sync += own.eq(self._hardware(register, field.name))
        self._answer(m, values)
        raised = [values[f"{r.name}.{f.name}"] & values[f.enable] for r, f in fields if f.enable]
        m.d.sync += self.interrupt.eq(Cat(raised).any())
        return m

    def _hardware(self, register: Register, name: str) -> Value:
        return getattr(getattr(self.hardware, register.name), name)

    def _value(self, register: Register, field: Field) -> Value:
        """What ``field`` is: a constant, an input, a register that drives an output, or one of its own."""
        if field.kind is Kind.CONSTANT:
            return Const(field.reset, field.bits)
        if field.kind in (Kind.STATUS, Kind.SETTING, Kind.PULSE, Kind.PORT):
            return self._hardware(register, field.name)
        return Signal(field.bits, name=f"{register.name}_{field.name}", init=field.reset)

    def _writable(self, m: Module, register: Register, field: Field, own: Value, here: Value) -> None:
        """Write ``field`` while ``here`` is high; the bus keeps word and strobes until the write is answered."""
        word, strobe = self._port.data[field.low :], self._port.strobe
        ones = Cat(word[bit] & strobe[(field.low + bit) // 8] & here for bit in range(field.bits))
        if field.kind is Kind.PULSE:
            m.d.sync += own.eq(ones)
        elif field.kind is Kind.EVENT:
            m.d.sync += own.eq((own & ~ones) | self._hardware(register, f"{field.name}_set"))
        else:
            lanes = range(field.low // 8, (field.low + field.bits - 1) // 8 + 1)
            for lane in lanes:
                part = slice(max(8 * lane - field.low, 0), min(8 * lane + 8 - field.low, field.bits))
                with m.If(here & strobe[lane]):
                    m.d.sync += own[part].eq(word[part])
            if field.kind is Kind.PORT:
                written = self._hardware(register, f"{field.name}_written")
                m.d.sync += written.eq(here & strobe[lanes.start : lanes.stop].any())

    def _answer(self, m: Module, values: Mapping[str, Value]) -> None:
        """A read is answered in three steps: which register, and the constant one; its group's word; the word.

        One step would take a third more lookup tables, since mappers then decode the address for every bit.
        """
        number = self._port.read_address[_WORD:]
        readable = [register for register in self._map.registers if register.readable]
        words = {register.address >> _WORD: self._word(register, values) for register in readable}
        constants = {place: word for place, word in words.items() if isinstance(word, Const)}
        answer, error = pipeline.driver(m, self._port.answer), pipeline.driver(m, self._port.read_error)
        every = Cat(constants.get(place, Const(0, BITS)) for place in range(1 << len(number)))
        parts = [pipeline.register(m, every.word_select(number, BITS), "constant")]
        for place in (place for place in words if place not in constants):
            parts.append(words[place] & pipeline.register(m, number == place, "selected").replicate(BITS))
        grouped = [reduce(or_, parts[first : first + _GROUP]) for first in range(0, len(parts), _GROUP)]
        groups = [pipeline.register(m, word, "group") for word in grouped]
        wrong = pipeline.delayed(m, ~self._is_one_of(number, words), ANSWER - 1, "wrong")
        with m.If(pipeline.delayed(m, self._port.read, ANSWER - 1, "read", control=True)):
            m.d.sync += answer.eq(reduce(or_, groups))
            m.d.sync += error.eq(wrong)
        write_error = pipeline.driver(m, self._port.write_error)
        writable = [register.address >> _WORD for register in self._map.registers if register.writable]
        with m.If(self._port.write):
            m.d.sync += write_error.eq(~self._is_one_of(self._port.write_address[_WORD:], writable))

    @staticmethod
    def _word(register: Register, values: Mapping[str, Value]) -> Value:
        """The word that software reads; bits without a field, and those that are only written, are 0."""
        if all(field.kind is Kind.CONSTANT for field in register.fields):
            return Const(register.reset, BITS)
        parts: list[Value] = []
        for field in register.fields:
            parts.append(Const(0, field.low - len(Cat(parts))))
            readable = field.kind.readable
            parts.append(values[f"{register.name}.{field.name}"] if readable else Const(0, field.bits))
        return Cat(parts, Const(0, BITS - len(Cat(parts))))

    @staticmethod
    def _is_one_of(number: Value, numbers: Collection[int]) -> Value:
        return Const(sum(1 << place for place in numbers), 1 << len(number)).bit_select(number, 1)
