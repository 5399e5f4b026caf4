"""A stream without backpressure to several sinks."""

from typing import Any

from amaranth import Module


def broadcast(m: Module, source: Any, *sinks: Any) -> None:
    """Every transfer of ``source`` to all ``sinks``, which are always ready, in the same cycle."""
    for sink in sinks:
        m.d.comb += [
            sink.valid.eq(source.valid),
            sink.payload.eq(source.payload),
        ]
