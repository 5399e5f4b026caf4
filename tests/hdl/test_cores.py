"""What a design's core states is asked once, and leaves nothing behind."""

import gc
import warnings
from dataclasses import replace

from amaranth import Module
from amaranth.hdl import Fragment

from tests.hdl.parallel.designs import make
from tfra.hdl.cores import microarchitecture
from tfra.hdl.serial.serial import Serial
from tfra.model.choices import SERIAL


def test_the_microarchitecture_stays_with_its_design() -> None:
    design = make(2, 2)
    core = microarchitecture(design)
    assert microarchitecture(design) is core
    assert microarchitecture(replace(design)) is not core
    assert isinstance(microarchitecture(replace(design, architecture=SERIAL)), Serial)


def test_blocks_that_are_asked_are_deleted_in_silence() -> None:
    Fragment.get(Module(), None)  # Amaranth warns of what is not elaborated once anything was
    with warnings.catch_warnings(record=True) as said:
        gc.collect()  # what others have left
        warnings.simplefilter("always")
        said.clear()
        assert microarchitecture(make(2, 2)).latency > 0
        gc.collect()
    assert said == []
    assert gc.get_freeze_count() == 0
