"""Finding: regions of the model's contacts in their order, and how each frame ends."""

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import connect, flipped

from tests.hdl.skin.skins import frames_of, skin_of
from tests.marks import long
from tfra.hdl.skin.finding import Finding
from tfra.hdl.skin.pages import Pages
from tfra.hdl.skin.payloads import height
from tfra.hdl.skin.peaks import Peaks
from tfra.model.skin.finding import Mark
from tfra.model.skin.smoothing import smoothing
from tfra.model.skin.windows import places
from tfra.sim.harness import Driver, bursts, flowing, random_stalls


class Searched(wiring.Component):
    """The block with the heights of frames, from which peaks are made."""

    def __init__(self, skin):
        self._skin = skin
        self.finding, self.peaks, self.heights = Finding(skin), Peaks(skin), Pages(skin, height(skin))
        members = self.finding.signature.members
        super().__init__({
            "i": self.peaks.signature.members["i"],
            "region": members["region"],
            "ending": members["ending"],
        })

    def elaborate(self, platform):
        m = Module()
        finding, peaks, heights = self.finding, self.peaks, self.heights
        m.submodules.finding, m.submodules.peaks, m.submodules.heights = finding, peaks, heights
        connect(m, peaks.o, finding.i)
        connect(m, finding.region, flipped(self.region))
        connect(m, finding.ending, flipped(self.ending))
        for sink in (peaks.i, heights.i):
            m.d.comb += sink.valid.eq(self.i.valid)
            m.d.comb += sink.payload.eq(self.i.payload)
        m.d.comb += [
            finding.ends.eq(peaks.ends),
            finding.highest.eq(peaks.highest),
            heights.page.eq(finding.page),
            heights.place.eq(finding.place),
            heights.read.eq(1),
            finding.height.eq(heights.o),
            finding.settings.most.eq(self._skin.choices.most),
            finding.settings.threshold.eq(self._skin.choices.word),
            finding.settings.gap.eq(self._skin.choices.gap),
        ]
        return m


CASES = [
    ((9, 11), {"most": 4}, 0, flowing),
    ((9, 11), {"most": 1, "gap": 0, "threshold": 1.0}, 1, random_stalls),
    ((11, 9), {"most": 64, "gap": 4, "threshold": 1 / 256}, 2, bursts),
    *long(((5, 16), {"most": 3, "gap": 1}, 5, random_stalls), ((17, 33), {"most": 7, "gap": 3}, 3, bursts)),
]


@pytest.mark.parametrize(("shape", "choices", "seed", "stalls"), CASES)
def test_contacts_are_those_of_the_model(shape, choices, seed, stalls):
    skin = skin_of(*shape, **choices)
    codes = frames_of(skin, seed, 10)
    found, _ = skin.find(codes)
    records = np.maximum(found.found, 1)
    driver, ends = Driver(Searched(skin), seed, limit=100_000), np.cumsum(records)
    # The heights of a frame may come when all that is known of the one before the last has left.
    leave = driver._leave
    leave["i"] = lambda number, record, _: len(record.values["ending"]) >= (0, 0, *ends)[number // codes[0].size]
    driver.add_source("i", smoothing(codes).ravel().tolist(), flowing)
    driver.add_sink("region", ends[-1], stalls)
    driver.add_sink("ending", ends[-1], stalls)
    driver.simulate()
    endings, regions = driver.record.values["ending"], driver.record.values["region"]
    assert np.flatnonzero([each["last"] for each in endings]).tolist() == (ends - 1).tolist()
    assert [each["dropped"] for each in endings if each["last"]] == found.dropped.tolist()
    assert not any(each["dropped"] for each in endings if not each["last"])
    empty = [number for number, each in enumerate(regions) if not each["taxels"]]
    assert empty == (ends[found.found == 0] - 1).tolist()
    there = [each for each in regions if each["taxels"]]
    taxels = np.array([each["taxels"] for each in there])
    assert (taxels == found.taxels).all()
    for name, want in (("rows", found.row), ("columns", found.column)):
        assert (places(np.array([each[name]["total"] for each in there]), taxels) == want).all()
    assert [each["touching"] for each in there] == [bool(marks & Mark.TOUCHING) for marks in found.marks]
