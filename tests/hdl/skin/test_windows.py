"""Windows: the codes of the model's windows, zero beyond the array, and when a frame is read."""

import random

import numpy as np
import pytest

from tests.hdl.skin.skins import skin_of, small_window
from tests.marks import STALLS
from tfra.hdl.skin.windows import Windows
from tfra.model.skin.windows import windows
from tfra.sim.harness import Driver, flowing, plain

SKIN = skin_of(6, 8, small_window(3, 4))
CONTACTS = 12


def read(frames, contacts, endings, stall_in=flowing, stall_out=flowing):
    """Taxels of all windows, their cycles, and the pages of the frames that were done."""
    block, done, held = Windows(SKIN), [], 0
    driver = Driver(block, 1, limit=5000)
    driver.add_source("contact", contacts, stall_in)
    driver.add_source("ending", endings, stall_in)
    driver.add_sink("taxel", len(contacts) * SKIN.window.sensor.taxels, stall_out)

    def memory(ctx):
        nonlocal held
        while len(done) < len(frames):
            page, place, enable, ends = yield
            place = plain(place)
            if enable:
                inside = place["row"] < 6 and place["column"] < 8
                held = int(frames[len(done), place["row"], place["column"]]) if inside else 1
            ctx.set(block.code, held)
            if ends:
                done.append(page)

    driver.add_watch(memory, block.page, block.place, block.read, block.done)
    driver.simulate()
    return driver.record, done


def cases(seed):
    rng = np.random.default_rng(seed)
    frames = rng.integers(-2048, 2048, (3, 6, 8))
    last = np.isin(np.arange(CONTACTS), (3, 4, CONTACTS - 1))
    frame = np.cumsum(last) - last
    top, left = rng.integers(-2, 6, CONTACTS), rng.integers(-3, 8, CONTACTS)
    taxels = rng.integers(0, 3, CONTACTS)
    cut = windows(frames, frame, (top, left), SKIN.shape)
    cut[taxels == 0] = 0
    contacts = [
        {"row": 0, "column": 0, "marks": 0, "taxels": int(n), "top": int(t), "left": int(c)}
        for n, t, c in zip(taxels, top, left, strict=True)
    ]
    return frames, contacts, [{"last": int(each), "dropped": 0} for each in last], cut


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_taxels_are_those_of_the_model(stall_in, stall_out):
    frames, contacts, endings, cut = cases(random.Random(f"{stall_in} {stall_out}").randrange(99))
    record, done = read(frames, contacts, endings, stall_in, stall_out)
    assert record.values["taxel"] == cut.ravel().tolist()
    assert done == [0, 1, 0]


def test_a_taxel_a_cycle_after_the_stated_latency():
    record, _ = read(*cases(1)[:3])
    cycles = np.array(record.cycles["taxel"]).reshape(CONTACTS, -1)
    assert (np.diff(cycles, axis=1) == 1).all()
    assert cycles[0, 0] == 1 + Windows.latency
