"""The registers behind the bus, against a model of the map, in Amaranth's simulator."""

import random
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import pytest

from tests.hdl.bus.manager import OKAY, SLVERR, Manager, simulated
from tests.hdl.bus.model import Access, Model, accesses, bits
from tests.marks import long
from tfra.codegen.registers.source import register_map
from tfra.hdl.bus.map import Field, Kind, Register, RegisterMap
from tfra.hdl.bus.registers import Registers
from tfra.sim.harness import play

MAP = register_map({"ROWS": 10, "COLUMNS": 12, "HASH_LOW": 0x89ABCDEF, "LOADABLE": 1, "LOAD_LENGTH": 4711})

ODD = RegisterMap(
    (
        Register("MIXED", 0x4, (
            Field("across", 5, 13, Kind.SETTING, 0x1234),
            Field("pulse", 18, 3, Kind.PULSE),
            Field("event", 23, 1, Kind.EVENT, 1, enable="MIXED.across_top"),
            Field("across_top", 24, 1, Kind.SETTING, 1),
        )),
        Register("SMALL", 0x10, (
            Field("count", 1, 2, Kind.COUNTER, clear="CLEAR.now"), Field("free", 4, 2, Kind.COUNTER, 3),
            Field("last", 9, 7, Kind.CAPTURED, 5),
        )),
        Register("CLEAR", 0x14, (Field("now", 9, 1, Kind.PULSE), Field("word", 12, 12, Kind.PORT))),
        Register("FIXED", 0x18, (Field("is", 3, 9, Kind.CONSTANT, 0x155), Field("seen", 14, 4, Kind.STATUS))),
    )
)  # fmt: skip
"""Fields of every kind that begin and end inside bytes."""


class Side:
    """The hardware's side of ``dut``: makes things happen there and in the ``model``."""

    def __init__(self, ctx: Any, dut: Any, model: Model) -> None:
        self._ctx, self._dut, self._model = ctx, dut, model

    def _port(self, path: str, ending: str = "") -> Any:
        register, _, name = path.partition(".")
        return getattr(getattr(self._dut.hardware, register), f"{name}{ending}")

    async def happen(self, path: str, value: int) -> None:
        kind = self._model.fields[path].kind
        self._model.happen(path, value)
        if kind in (Kind.STATUS, Kind.CAPTURED):
            self._ctx.set(self._port(path), value)
        if kind is not Kind.STATUS:
            strobe = self._port(path, {Kind.EVENT: "_set", Kind.COUNTER: "_up", Kind.CAPTURED: "_store"}[kind])
            self._ctx.set(strobe, 1)
            await self._ctx.tick()
            self._ctx.set(strobe, 0)

    def check(self) -> None:
        """Outputs have the values of the model."""
        for path, field in self._model.fields.items():
            written = field.kind is Kind.PORT and self._model.pulses[path]
            if field.kind is Kind.SETTING or written:
                assert self._ctx.get(self._port(path)) == self._model.values[path], path
        assert self._ctx.get(self._dut.interrupt) == self._model.interrupt

    async def count(self, seen: dict[str, int]) -> None:
        """Count the cycles in which a bit of each pulse is high."""
        ports = [self._port(p, "_written" * (self._model.fields[p].kind is Kind.PORT)) for p in seen]
        while True:
            _, _, *high = await self._ctx.tick().sample(*ports)
            seen |= {path: seen[path] + bool(each) for path, each in zip(seen, high, strict=True)}


def agree(registers: RegisterMap, script: Iterable[Access], rng: random.Random | None, model: Model) -> None:
    """Play ``script`` and compare every answer, output and pulse with ``model``."""
    dut, seen = Registers(registers), dict.fromkeys(model.pulses, 0)

    async def process(ctx: Any) -> None:
        manager, side = Manager(ctx, dut.bus, rng), Side(ctx, dut, model)
        for action, *arguments in script:
            if action == "happen":
                await side.happen(*arguments)
            else:
                got = await getattr(manager, action)(*arguments)
                assert got == getattr(model, action)(*arguments), (action, *map(hex, arguments))
            await ctx.tick().repeat(2)
            side.check()

    async def count(ctx: Any) -> None:
        await Side(ctx, dut, model).count(seen)

    simulated(dut, process, background=[count], check=dut.bus)
    assert seen == model.pulses


@pytest.mark.parametrize("registers", [MAP, ODD], ids=["tfra", "odd"])
@pytest.mark.parametrize("seed", [0, *long(*range(1, 6))])
def test_anything(registers: RegisterMap, seed: int) -> None:
    rng = random.Random(seed)
    agree(registers, accesses(registers, rng, 500 if seed else 120), rng, Model(registers))


@pytest.mark.parametrize("registers", [ODD, *long(MAP)], ids=["odd", "tfra"])
def test_every_bit(registers: RegisterMap) -> None:
    agree(registers, bits(registers), None, Model(registers))


def test_a_planted_difference_is_noticed() -> None:
    """Of the model's map one reset value, one bit, or one clear differs."""
    script = [
        ("happen", "ERRORS.stale", 1),
        ("happen", "LOAD_COUNT.words", 1),
        ("write", 0x40, 2),
        ("write", 0x48, 16),
        *(("read", address) for address in (0x40, 0x48, 0x84)),
    ]
    agree(MAP, script, None, Model(MAP))
    for path, change in {
        "CONTROL.taxel_forces": {"reset": 0},
        "ERRORS.stale": {"low": 8},
        "LOAD_COUNT.words": {"clear": ""},
    }.items():
        with pytest.raises(AssertionError):
            agree(MAP, script, None, Model(changed(MAP, path, change)))


def changed(registers: RegisterMap, path: str, change: Mapping[str, Any]) -> RegisterMap:
    """The map with another field at ``path``."""
    name, _, of = path.partition(".")
    found = registers[name]
    fields = tuple(replace(field, **change) if field.name == of else field for field in found.fields)
    others = tuple(replace(r, fields=fields) if r.name == name else r for r in registers.registers)
    return RegisterMap(others)


def test_reset_values_of_the_core() -> None:
    """Literally, all inputs being 0."""
    dut = Registers(MAP)
    words = {0x00: 0x54465241, 0x04: 0x01000000, 0x08: 0x89ABCDEF, 0x10: 0x300, 0x14: 0x000C000A, 0x28: 4711, 0x40: 8}
    words |= {0x2C: 1, 0xA0: 8}
    zero = (*range(0x44, 0x58, 4), *range(0x60, 0x78, 4), *range(0x84, 0x94, 4), *range(0xA4, 0xB4, 4), 0xBC, 0xC0)

    async def process(ctx: Any) -> None:
        manager = Manager(ctx, dut.bus)
        for address, word in {**words, **dict.fromkeys(zero, 0)}.items():
            assert await manager.read(address) == (word, OKAY)
            assert next(r for r in MAP.registers if r.address == address).reset == word
        for address in (0x30, 0x3C, 0x58, 0x78, 0x80, 0x94, 0xC4, 0xFC):  # 0x80 is LOAD_DATA, which is only written
            assert await manager.read(address) == (0, SLVERR)
        for address in (0x00, 0x44, 0x60, 0x8C, 0x94, 0xFC):
            assert await manager.write(address, 1) == SLVERR

    simulated(dut, process)


def test_hardware_and_software_in_the_same_cycle() -> None:
    """A set wins over a clear; a counter that is cleared counts on."""
    write = {"bus.awvalid": 1, "bus.wvalid": 1, "bus.wstrb": 15}  # takes effect two cycles later
    errors = {**write, "bus.awaddr": 0x48, "bus.wdata": 3}
    reset, up = {**write, "bus.awaddr": 0x40, "bus.wdata": 2}, "hardware.LOAD_COUNT.words_up"

    def read(address: int, *before: Mapping[str, int]) -> int:
        cycles = [*before, {}, {}, {}, {"bus.arvalid": 1, "bus.araddr": address}, *[{}] * 5]
        return int(play(Registers(MAP), cycles, ["bus.rdata"])[-1]["bus.rdata"])

    both = {"hardware.ERRORS.short_frame_set": 1, "hardware.ERRORS.long_frame_set": 1}
    assert read(0x48, both, errors) == 0
    assert read(0x48, both, errors, {}, {"hardware.ERRORS.short_frame_set": 1}) == 1
    assert read(0x84, {up: 1}, {up: 1}) == 2
    assert read(0x84, {up: 1}, reset) == 0
    assert read(0x84, {up: 1}, reset, {}, {}, {up: 1}) == 1  # the pulse is there a cycle after the write
