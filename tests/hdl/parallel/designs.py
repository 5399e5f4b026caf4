"""For the tests of parallel blocks: designs of TFRA, blocks joined to one, a test bench of its own."""

from collections.abc import Callable, Iterable
from typing import Any

from amaranth import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import Out
from amaranth.sim import Simulator

from tfra.hdl.lib.broadcast import broadcast
from tfra.model.choices import FORMATS, Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.sim.harness import port as port_at


def make(
    rows: int,
    columns: int,
    formats: str | Formats = "standard",
    *,
    bits: int = 14,
    threshold: int | None = None,
    steps: int = 100,
    tolerance: float = 0.0,
    lanes: int = 4,
    words: int = 4,
    pitches: tuple[float, float] = (4.0, 2.0),
    thickness: float = 3.0,
) -> TfraDesign:
    """A design with these formats, or those of this name; pitches and thickness in mm."""
    return TfraDesign(
        SensorArray(rows, columns, pitches[0] * 1e-3, pitches[1] * 1e-3, thickness * 1e-3),
        adc=Adc(bits, contact_threshold=threshold),
        search=Search(steps, tolerance),
        formats=FORMATS[formats] if isinstance(formats, str) else formats,
        architecture=Architecture(lanes, words),
    )


def label(design: Design) -> str:
    """Size, lanes, words a cycle and formats of a design, for the name of a test."""
    sensor, architecture = design.sensor, design.architecture
    formats = design.formats.name.replace(" ", "-")
    return f"{sensor.rows}x{sensor.columns}-{architecture.mac_lanes}-{architecture.vector_words}-{formats}"


def simulate(dut: Any, bench: Callable[[Any], Any]) -> None:
    """Run ``bench`` beside ``dut`` to its end."""
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()


class Joined(wiring.Component):
    """Blocks as one.

    Arguments:
        blocks: by name.
        ports: by name of a port, that of a block, as "block.port", or of all blocks that read it.
        wires: pairs of such ports: a stream, and its sink.
    """

    def __init__(
        self, blocks: dict[str, Any], ports: dict[str, str | tuple[str, ...]], wires: Iterable[tuple[str, str]] = ()
    ) -> None:
        self.blocks, self._wires = blocks, wires
        self._inner = {name: paths if isinstance(paths, tuple) else (paths,) for name, paths in ports.items()}
        members = {}
        for name, (path, *_) in self._inner.items():
            block, port = path.split(".")
            members[name] = blocks[block].signature.members[port]
        super().__init__(members)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in self.blocks.items():
            m.submodules[name] = block
        for source, sink in self._wires:
            self._connect(m, self._port(source), self._port(sink))
        for name, paths in self._inner.items():
            own, inner = wiring.flipped(getattr(self, name)), [self._port(path) for path in paths]
            if self.signature.members[name].flow is Out:
                wiring.connect(m, inner[0], own)
            else:
                self._connect(m, own, *inner)
        return m

    def _port(self, path: str) -> Any:
        block, _, port = path.partition(".")
        return port_at(self.blocks[block], port)

    @staticmethod
    def _connect(m: Module, source: Any, *sinks: Any) -> None:
        """A stream to its sink, or one without backpressure to any."""
        if source.signature.always_ready:
            broadcast(m, source, *sinks)
        else:
            wiring.connect(m, source, *sinks)
