"""Streams between blocks that a simulation may watch."""

from typing import Any

from amaranth import Cat, Module, Shape, Signal

from tfra.hdl.interface.microarchitecture import Probe


def probe_of(stage: str, port: str, shape: Any, keys: tuple[int | str, ...], transfers: int) -> Probe:
    """A probe of the stream ``port`` of a block, whose payload has this ``shape``."""
    members = [shape[key].shape for key in keys] if keys else [shape]
    words = tuple((Shape.cast(member).width, Shape.cast(member).signed) for member in members)
    return Probe(stage, port, keys, words, transfers)


def add_probe(m: Module, probe: Probe, block: Any) -> None:
    """Name the stream of ``block`` that ``probe`` watches; nothing depends on it, so it costs no hardware."""
    transfer = Signal(name=f"probe_{probe.stage}")
    words = Signal(sum(bits for bits, _ in probe.words), name=f"probe_{probe.stage}_words")
    name, _, member = probe.port.partition(".")
    port = getattr(block, name)
    payload = port.payload[member] if member else port.payload
    members = [payload[key] for key in probe.keys] if probe.keys else [payload]
    m.d.comb += transfer.eq(port.valid & port.ready)
    m.d.comb += words.eq(Cat(members))
