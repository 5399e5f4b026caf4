"""A skin: codes of a large array in, a record of each contact out."""

from typing import Any

from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface import ports
from tfra.hdl.lib.pipeline import occupancy, register
from tfra.hdl.lib.streams import Fifo, Fork
from tfra.hdl.skin.finding import Finding
from tfra.hdl.skin.lines import raster
from tfra.hdl.skin.pages import Pages
from tfra.hdl.skin.payloads import PAGES, contact, ending, height, settings
from tfra.hdl.skin.peaks import Peaks
from tfra.hdl.skin.places import Places
from tfra.hdl.skin.records import Records
from tfra.hdl.skin.smoothing import Smoothing
from tfra.hdl.skin.windows import Windows
from tfra.model.skin.skin import Skin

CONTACTS = 8
"""Contacts that wait for the core or for its words: at least as many as a core holds, or it would wait for them."""


class SkinUnit(wiring.Component):
    """In: codes of frames, row by row.  Out: words of :func:`tfra.model.skin.records.records`, ``last`` ends a record.

    ::

        taxel ─┬▶ smoothing ─┬▶ peaks ─▶ finding ─┬▶ regions ─▶ places ─▶ contacts ─┬▶ windows ─▶ (core) ─┐
               │             └▶ pages ─────▲      └▶ endings ───────────────────────┼────┘                ▼
               └▶ pages ─────────────────────────────────────────────── windows     └─────────────▶ records ─▶ result

    A taxel a cycle, also from frame to frame, unless ``PAGES`` frames are there: a page is free when the last window of
    its frame has been read.  The settings ``contacts`` count for a frame as they are when its search begins.
    """

    def __init__(self, skin: Skin) -> None:
        self._skin = skin
        self._core = microarchitecture(skin.window).build()
        load = {name: port for name, port in self._core.signature.members.items() if name == "load"}
        super().__init__({
            **load,  # as the core's
            "contacts": In(settings(skin.choices)),
            "taxel": In(stream.Signature(ports.taxel(skin.window))),
            "result": Out(stream.Signature(ports.result(skin))),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.core = core = self._core
        m.submodules.windows = windows = Windows(self._skin)
        m.submodules.records = records = Records(self._skin)
        if "load" in self.signature.members:
            connect(m, flipped(self.load), core.load)
        connect(m, windows.taxel, core.taxel)
        connect(m, core.result, records.words)
        connect(m, records.result, flipped(self.result))
        finding = self._take(m, windows)
        m.submodules.places = places = Places(self._skin)
        connect(m, finding.region, places.region)
        self._hand(m, "contact", contact(self._skin), places.contact, (windows.contact, records.contact))
        self._hand(m, "ending", ending(self._skin), finding.ending, (windows.ending, records.ending))
        return m

    def _take(self, m: Module, windows: Windows) -> Finding:
        """Frames to their pages and to the search."""
        skin = self._skin
        m.submodules.codes = codes = Pages(skin, ports.taxel(skin.window))
        m.submodules.smoothing = smoothing = Smoothing(skin)
        m.submodules.heights = heights = Pages(skin, height(skin))
        m.submodules.peaks = peaks = Peaks(skin)
        m.submodules.finding = finding = Finding(skin)
        taken = self.taxel.valid & self.taxel.ready
        *_, last = raster(m, taken, skin.sensor.rows, skin.sensor.columns)
        pages = occupancy(m, PAGES, taken & last, windows.done)
        code, there = register(m, self.taxel.payload, "code"), register(m, taken, "there", control=True)
        connect(m, peaks.o, finding.i)
        for sink in (codes.i, smoothing.i):
            m.d.comb += [
                sink.valid.eq(there),
                sink.payload.eq(code),
            ]
        for sink in (heights.i, peaks.i):
            m.d.comb += [
                sink.valid.eq(smoothing.o.valid),
                sink.payload.eq(smoothing.o.payload),
            ]
        m.d.comb += [
            self.taxel.ready.eq(~pages[-1]),
            codes.page.eq(windows.page),
            codes.place.eq(windows.place),
            codes.read.eq(windows.read),
            windows.code.eq(codes.o),
            heights.page.eq(finding.page),
            heights.place.eq(finding.place),
            heights.read.eq(1),
            finding.height.eq(heights.o),
            finding.ends.eq(peaks.ends),
            finding.highest.eq(peaks.highest),
        ]
        connect(m, flipped(self.contacts), finding.settings)
        return finding

    @staticmethod
    def _hand(m: Module, name: str, shape: Any, source: Any, sinks: tuple[Any, ...]) -> None:
        """Every transfer to all ``sinks``, which take it at their own times."""
        m.submodules[f"{name}_fork"] = fork = Fork(shape, len(sinks))
        connect(m, source, fork.i)
        for way, sink in enumerate(sinks):
            m.submodules[f"{name}s_{way}"] = fifo = Fifo(shape, CONTACTS)
            connect(m, fork.o[way], fifo.i)
            connect(m, fifo.o, sink)
