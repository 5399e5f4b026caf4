"""The table of result words at the head of the Verilog names every word once, in order."""

import pytest

from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.header import frame_lines
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

DESIGNS = [TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)) for rows, columns in ((4, 4), (5, 9))]


@pytest.mark.parametrize("design", DESIGNS, ids=lambda design: f"{design.sensor.rows}x{design.sensor.columns}")
def test_every_word_has_a_field(design: Design) -> None:
    lines = [line.split() for line in frame_lines(sidecar(design))]
    begin = lines.index(["words", "field", "bits", "format", "lsb", "unit"])
    end = lines.index(["meaning", "of", "the", "fields"])
    words = [line[0] for line in lines[begin + 1 : end]]
    bounds = [tuple(map(int, word.split(".."))) for word in words]
    assert [place for bound in bounds for place in range(bound[0], bound[-1] + 1)] == list(range(design.frame_words))
    assert words == [str(bound[0]) if bound[0] == bound[-1] else f"{bound[0]}..{bound[-1]}" for bound in bounds]
    assert {len(bound) for bound in bounds} == {1, 2}
