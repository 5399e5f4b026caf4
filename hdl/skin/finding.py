"""Finding the contacts of a frame; see :mod:`tfra.model.skin.finding`."""

from typing import Any

from amaranth import Module, Mux, Signal, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.lib.pipeline import driver, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.skin.candidates import Candidates
from tfra.hdl.skin.grown import Grown
from tfra.hdl.skin.payloads import PAGES, ending, height, peak, place, region, settings
from tfra.hdl.skin.regions import Regions
from tfra.model.skin.skin import Skin


class Finding(wiring.Component):
    """In: peaks of frames, and heights at places.  Out: the regions of the contacts, the highest peak's first.

    ======  ==================================================================================================
    IDLE    waits for a frame
    CLEAR   clears the bitmaps, row by row
    SETTLE  waits until the lowest height of a candidate is computed, once a frame
    SEARCH  searches the candidates for the highest that is free
    DECIDE  whether there is one; the record before is the last one otherwise
    END     sends what is now known of the record before
    START   waits until the region before has been taken
    FILL    collects the region, which is then sent
    GROW    takes the taxels about it, meanwhile; then SEARCH
    BLANK   sends a region without taxels of a frame without contact, when the one before has been taken
    ======  ==================================================================================================

    A frame of the array's R rows takes R + 15 cycles and, for each contact, about 30, one for each candidate, seven to
    nine for each taxel of its region, and ``5 + 3 gap`` for each of its rows.
    """

    def __init__(self, skin: Skin) -> None:
        self._rows, self._columns = skin.sensor.rows, skin.sensor.columns
        self._candidates, self._regions, self._grown = Candidates(skin), Regions(skin), Grown(skin)
        super().__init__({
            "settings": In(settings(skin.choices)),  # as they are when the search of a frame begins
            "i": In(always_ready_stream(peak(skin))),
            "ends": In(1),  # see ``Peaks``
            "highest": In(height(skin)),
            "page": Out(range(PAGES)),  # of the frame that is searched
            "place": Out(place(skin)),  # of a height in it ...
            "height": In(height(skin)),  # ... a cycle later
            "region": Out(stream.Signature(region(skin))),
            "ending": Out(stream.Signature(ending(skin))),  # of the same record, later
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        candidates, regions, grown = self._candidates, self._regions, self._grown
        m.submodules.candidates, m.submodules.regions, m.submodules.grown = candidates, regions, grown
        connect(m, flipped(self.i), candidates.i)
        page = Signal(range(PAGES), init=PAGES - 1)
        gap, most = Signal.like(self.settings.gap, reset_less=True), Signal.like(self.settings.most, reset_less=True)
        with m.If(candidates.begin):
            m.d.sync += [
                page.eq(~page),
                gap.eq(self.settings.gap),
                most.eq(self.settings.most),
            ]
        m.d.comb += [
            candidates.ends.eq(self.ends),
            candidates.highest.eq(self.highest),
            candidates.threshold.eq(self.settings.threshold),
            self.page.eq(page),
            regions.peak.eq(candidates.best),
            regions.height.eq(self.height),
            self.place.eq(regions.place),
            grown.first.eq(regions.o.rows.first),
            grown.last.eq(regions.o.rows.last),
            grown.gap.eq(gap),
        ]
        self._control(m, most)
        return m

    def _control(self, m: Module, most: Signal) -> None:
        """The states, and the region that waits to be taken."""
        regions = self._regions
        found = Signal.like(most)
        clear, fill, grow = Signal(), Signal(), Signal()
        blank = Signal()  # the region that waits is that of a frame without contact
        waiting = Signal()
        clear_row, cleared = wrapping_counter(m, clear, self._rows, "clear_row")
        self._bitmaps(m, clear, clear_row, fill, grow)
        m.d.comb += [
            self.region.valid.eq(waiting),
            self.region.payload.eq(regions.o),
        ]
        with m.If(blank):
            m.d.comb += self.region.payload.taxels.eq(0)
        with m.If(self.region.ready):
            m.d.sync += waiting.eq(0)
        with m.FSM():
            self._add_search(m, found, found == most, clear, cleared)
            with m.State("START"), m.If(~waiting):
                m.d.comb += regions.start.eq(1)
                m.d.sync += found.eq(found + 1)
                m.d.sync += blank.eq(0)
                m.next = "FILL"
            with m.State("FILL"):
                m.d.comb += fill.eq(1)
                with m.If(regions.done):
                    m.d.comb += self._grown.start.eq(1)
                    m.d.sync += waiting.eq(1)
                    m.next = "GROW"
            with m.State("GROW"):
                m.d.comb += grow.eq(1)
                with m.If(self._grown.done):
                    m.next = "SETTLE"
            with m.State("BLANK"), m.If(~waiting):
                m.d.sync += waiting.eq(1)
                m.d.sync += blank.eq(1)
                m.next = "END"

    def _add_search(self, m: Module, found: Signal, full: Value, clear: Signal, cleared: Value) -> None:
        """The states from a frame's first to the start of a region."""
        candidates, ending = self._candidates, driver(m, self.ending.payload)
        some = candidates.left != 0
        with m.State("IDLE"):
            m.d.comb += candidates.begin.eq(candidates.waiting)
            m.d.sync += found.eq(0)
            with m.If(candidates.waiting):
                m.next = "CLEAR"
        with m.State("CLEAR"):
            m.d.comb += clear.eq(1)
            with m.If(cleared):
                m.next = "SETTLE"
        with m.State("SETTLE"), m.If(candidates.settled):
            m.d.comb += candidates.search.eq(1)
            m.next = "SEARCH"
        with m.State("SEARCH"), m.If(candidates.searched):
            m.next = "DECIDE"
        with m.State("DECIDE"):
            m.d.sync += ending.last.eq(~some | full)
            m.d.sync += ending.dropped.eq(Mux(full, candidates.left, 0))
            with m.If(found != 0):
                m.next = "END"
            with m.Elif(some):
                m.next = "START"
            with m.Else():
                m.next = "BLANK"
        with m.State("END"):
            m.d.comb += self.ending.valid.eq(1)
            with m.If(self.ending.ready):
                m.next = "START"
            with m.If(self.ending.ready & ending.last):
                m.next = "IDLE"

    def _bitmaps(self, m: Module, clear: Value, clear_row: Value, fill: Value, grow: Value) -> None:
        """The taxels of the region, and those that are not free; a word for each row."""
        candidates, regions, grown = self._candidates, self._regions, self._grown
        word = unsigned(self._columns)
        region, taken = Ram(m, "region", word, self._rows), Ram(m, "taken", word, self._rows)
        region.write(
            clear | regions.region.write | grown.region.write,
            Mux(clear, clear_row, Mux(grow, grown.region.target, regions.region.target)),
            Mux(fill, regions.region.data, 0),
        )
        taken.write(
            clear | grown.taken.write,
            Mux(clear, clear_row, grown.taken.target),
            Mux(clear, 0, grown.taken.data),
        )
        of_region = region.read(Mux(grow, grown.region.row, regions.region.row))
        of_taken = taken.read(Mux(grow, grown.taken.row, Mux(fill, regions.taken.row, candidates.taken.row)))
        m.d.comb += [
            regions.region.word.eq(of_region),
            grown.region.word.eq(of_region),
            regions.taken.word.eq(of_taken),
            grown.taken.word.eq(of_taken),
            candidates.taken.word.eq(of_taken),
        ]
