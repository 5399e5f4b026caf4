"""AXI4-Lite's rules (AMBA IHI 0022, part B) at the port of the registers, and what the registers do."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from amaranth import Cat, Const, Mux, Signal, Value

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from bench.formal.streams import RULE, stays
from tfra.codegen.registers.source import register_map
from tfra.hdl.bus.axi_lite import ANSWER, AxiLite
from tfra.hdl.bus.map import Field, Kind, Register, RegisterMap
from tfra.hdl.bus.registers import Registers

ADDRESS = 5
_ONCE, _READY = "no request while the one before is not answered", "otherwise it is ready"
_ANSWERS, _SOON = "an answer only to a request", "every request is answered soon"
BAD_READ, GOOD_READ = "a read of an unmapped or write-only register is an error", "another read is none"
BAD_WRITE, GOOD_WRITE = "a write of an unmapped or read-only register is an error", "another write is none"
OKAY, SLVERR = 0, 2

MAP = RegisterMap((
    Register("SET", 0x0, (Field("low", 3, 7, Kind.SETTING, 5), Field("event", 12, 1, Kind.EVENT))),
    Register("FIXED", 0x4, (Field("is", 0, 32, Kind.CONSTANT, 0xC0DE),)),
    Register("ORDER", 0x8, (Field("pulse", 9, 1, Kind.PULSE), Field("word", 12, 9, Kind.PORT))),
    Register("COUNT", 0x10, (Field("number", 1, 4, Kind.COUNTER, clear="ORDER.pulse"),)),
))  # fmt: skip
"""Fields of several kinds; 0xC and all above 0x10 are unmapped."""

WHOLE = register_map({"ROWS": 10, "COLUMNS": 12, "LOADABLE": 1, "LOAD_LENGTH": 4711})


def channel(bus: Any, name: str, *words: str) -> Any:
    """A channel of ``bus`` as a stream."""
    payload = Cat(getattr(bus, f"{name}{word}") for word in words)
    return SimpleNamespace(valid=getattr(bus, f"{name}valid"), ready=getattr(bus, f"{name}ready"), payload=payload)


def requests(bench: Bench, bus: Any, claim: Callable[[str, Any, Any], None]) -> Any:
    """One answer for each request, soon; returns what has been requested."""
    m = bench.m
    now: dict[str, Any] = {}
    for name, words in (("ar", ("addr",)), ("aw", ("addr",)), ("w", ("data", "strb"))):
        request, answer = channel(bus, name, *words), channel(bus, "r" if name == "ar" else "b", "resp")
        there, payload = Signal(name=f"{name}_there"), Signal(len(request.payload), name=f"{name}_requested")
        with m.If(answer.valid & answer.ready):
            m.d.sync += there.eq(0)
        with m.If(request.valid & request.ready):
            m.d.sync += there.eq(1)
            m.d.sync += payload.eq(request.payload)
        now |= {name: there, f"{name}_payload": payload}
        claim(f"{name}: {_ONCE}", there, ~request.ready)
        claim(f"{name}: {_READY}", ~there, request.ready)
    for name, complete in (("r", now["ar"]), ("b", now["aw"] & now["w"])):
        answer = channel(bus, name, "resp")
        waits = Signal(range(AxiLite.latency + 1), name=f"{name}_waits")
        m.d.sync += waits.eq(Mux(complete & ~answer.valid, waits + 1, 0))
        claim(f"{name}: {_ANSWERS}", answer.valid, complete)
        claim(f"{name}: {_SOON}", complete & ~answer.valid, waits < ANSWER)
        now[f"{name}_waits"] = waits
        bench.lemma(waits <= ANSWER)
    return SimpleNamespace(**now)


def _request_lemmas(bench: Bench, now: Any, inner: Any, path: str, bus: Any) -> None:
    """The block's registers say the same as the requests."""
    for name in ("ar", "aw", "w"):
        there, waits = getattr(now, name), inner[f"{path}{name}_waits"]
        bench.lemma(inner[f"{path}{name}_free"] == ~there)
        bench.lemma(~there | (inner[f"{path}{name}_request"] == getattr(now, f"{name}_payload")))
        bench.lemma(there | ~waits)
    bench.lemma(inner[f"{path}ar_waits"] == (now.ar & (now.r_waits == 0) & ~bus.rvalid))
    complete = now.aw & now.w
    waiting = complete & (now.b_waits == 0) & ~bus.bvalid
    bench.lemma(inner[f"{path}aw_waits"] == (now.aw & ~now.w | waiting))
    bench.lemma(inner[f"{path}w_waits"] == (now.w & ~now.aw | waiting))


def axi_lite(bench: Bench, Block: Any) -> None:
    """Registers that keep an answer until the next one."""
    block = Block(ADDRESS)
    inner = bench.place(block)
    bus, port = block.bus, block.port
    started = bench.past(Const(1, 1))
    for access, words in ((port.read, (port.answer, port.read_error)), (port.write, (port.write_error,))):
        word = Cat(words)
        bench.assume(~started | bench.past(access, ANSWER) | (word == bench.past(word)))
    stays(bench, channel(bus, "r", "data", "resp"), f"r: {RULE}")
    stays(bench, channel(bus, "b", "resp"), f"b: {RULE}")
    now = requests(bench, bus, bench.claim)
    _request_lemmas(bench, now, inner, "", bus)
    for name, access, complete, there, words in (
        ("r", port.read, now.ar, now.ar_payload, port.read_address),
        (
            "b",
            port.write,
            now.aw & now.w,
            Cat(now.aw_payload, now.w_payload),
            Cat(port.write_address, port.data, port.strobe),
        ),
    ):
        valid, waits = getattr(bus, f"{name}valid"), getattr(now, f"{name}_waits")
        bench.claim(
            f"{name}: the registers are asked once, for what was requested", access, complete & (words == there)
        )
        begins = _timing(bench, access, complete, valid, waits)
        bench.claim(f"{name}: the answer is that of the registers", begins, bench.past(access, ANSWER))


def _timing(bench: Bench, access: Any, complete: Any, valid: Any, waits: Any) -> Any:
    """Lemmas of the cycles from an access to its answer; returns whether the answer begins."""
    begins = valid & ~bench.past(valid)
    for cycles in range(1, ANSWER):
        bench.lemma(bench.past(access, cycles) == (complete & ~valid & (waits == cycles)))
    bench.lemma(bench.past(access, ANSWER) == begins)
    bench.lemma(~valid | (complete & (waits == Mux(begins, ANSWER, 0))))
    return begins


def registers(bench: Bench, Block: Any) -> None:
    """A small map with nothing assumed: rules of the bus, errors, and a setting that software writes."""
    block = Block(MAP)
    now, begins = _rules(bench, block, MAP)
    constant, bus = MAP["FIXED"], block.bus
    here = now.ar_payload[2:] == constant.address >> 2
    bench.claim("a constant reads as it is", bus.rvalid & here, bus.rdata == constant.reset)
    _setting(bench, block, now, begins)


def all_registers(bench: Bench, Block: Any) -> None:
    """The map of every core."""
    _rules(bench, Block(WHOLE), WHOLE)


def _rules(bench: Bench, block: Any, registers: RegisterMap) -> Any:
    """Those of the bus, and which accesses are errors; returns the requests and whether a write's answer begins."""
    inner = bench.place(block)
    bus = block.bus
    stays(bench, channel(bus, "r", "data", "resp"), f"r: {RULE}")
    stays(bench, channel(bus, "b", "resp"), f"b: {RULE}")
    now = requests(bench, bus, lambda _, when, holds: bench.lemma(~when | holds))
    _request_lemmas(bench, now, inner, "axi_lite.", bus)
    _timing(bench, block._port.read, now.ar, bus.rvalid, now.r_waits)
    begins = _timing(bench, block._port.write, now.aw & now.w, bus.bvalid, now.b_waits)
    readable = _among(now.ar_payload[2:], [each for each in registers.registers if each.readable])
    writable = _among(now.aw_payload[2:], [each for each in registers.registers if each.writable])
    bench.claim(BAD_READ, bus.rvalid & ~readable, (bus.rresp == SLVERR) & (bus.rdata == 0))
    bench.claim(GOOD_READ, bus.rvalid & readable, bus.rresp == OKAY)
    bench.claim(BAD_WRITE, bus.bvalid & ~writable, bus.bresp == SLVERR)
    bench.claim(GOOD_WRITE, bus.bvalid & writable, bus.bresp == OKAY)
    return now, begins


def _among(number: Value, registers: list[Register]) -> Value:
    return Cat(number == register.address >> 2 for register in registers).any()


def _setting(bench: Bench, block: Any, now: Any, begins: Any) -> None:
    """SET.low is what its bytes were last written as, when the write is answered and as long as no other comes."""
    m, bus = bench.m, block.bus
    field = MAP["SET"].fields[0]
    kept = Signal(field.bits, init=field.reset)
    word, strobe = now.w_payload[:32], now.w_payload[32:]
    changed = Cat(Mux(strobe[(field.low + bit) // 8], word[field.low + bit], kept[bit]) for bit in range(field.bits))
    here = now.aw_payload[2:] == MAP["SET"].address >> 2
    after = Signal(field.bits)
    m.d.comb += after.eq(Mux(begins & here, changed, kept))
    m.d.sync += kept.eq(after)
    quiet = bus.bvalid | ~(now.aw & now.w)
    bench.lemma(~(now.aw & now.w) | bus.bvalid | (now.b_waits != 0) | (block.hardware.SET.low == kept))
    bench.claim("a setting is what was written", quiet, block.hardware.SET.low == after)


_WRITE = "with m.If(self._port.write):"
_RULES = {
    f"r: {RULE}": (
        'with m.If(pipeline.delayed(m, self._port.read, ANSWER - 1, "read", control=True)):',
        "with m.If(1):",
    ),
    f"b: {RULE}": (_WRITE, f"m.d.sync += write_error.eq(~write_error)\n        {_WRITE}"),
    BAD_READ: ("if register.readable]", "]"),
    GOOD_READ: ("error.eq(wrong)", "error.eq(1)"),
    BAD_WRITE: ("in self._map.registers if register.writable]", "in self._map.registers]"),
    GOOD_WRITE: ("write_error.eq(~self._is_one_of", "write_error.eq(self._is_one_of"),
}

PROOFS = [
    Proof(
        AxiLite,
        axi_lite,
        {
            f"r: {RULE}": ("with m.Elif(self._taken(channel)):", "with m.Else():"),
            f"b: {RULE}": ("with m.Elif(self._taken(channel)):", "with m.Else():"),
            **{f"{name}: {_ONCE}": ("free.eq(~valid)", "free.eq(1)") for name in ("ar", "aw", "w")},
            **{f"{name}: {_READY}": ("free = Signal(init=1", "free = Signal(init=0") for name in ("ar", "aw", "w")},
            **{f"{name}: {_ANSWERS}": ("with m.Elif(self._taken(channel)):", "with m.Elif(0):") for name in "rb"},
            **{f"{name}: {_SOON}": ("ANSWER - 1, f", "ANSWER, f") for name in "rb"},
            "r: the registers are asked once, for what was requested": ("waits.eq(0)", "waits.eq(waits)"),
            "b: the registers are asked once, for what was requested": ("write_waits & word_waits", "write_waits"),
            **{f"{name}: the answer is that of the registers": ("ANSWER - 1, f", "ANSWER - 2, f") for name in "rb"},
        },
        depth=4,
        size=f"{ADDRESS} address bits",
    ),
    Proof(
        Registers,
        registers,
        {
            **_RULES,
            "a constant reads as it is": ("reduce(or_, groups)", "~reduce(or_, groups)"),
            "a setting is what was written": ("self._port.write & (number ==", "self._port.write & (number !="),
        },
        depth=6,
        size=f"{len(MAP.registers)} registers",
    ),
    Proof(Registers, all_registers, _RULES, depth=6, size="those of a core"),
]
