"""Memory contents move from the Verilog into files, word by word, and nothing else changes."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.memories import Image, extract
from tfra.hdl.parallel.matvec.images import lane_images
from tfra.model.choices import Architecture, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

DESIGN = TfraDesign(SensorArray(3, 3, 4e-3, 2e-3, 3e-3), "lanes", search=Search(9), architecture=Architecture(4))

MODULE = """\
module top__lane(clk);
  reg [17:0] grid_27 [2:0];
  initial begin
    grid_27[0] = 18'h0a1a2;
    grid_27[1] = 18'h3f704;
    grid_27[2] = 18'h00000;
  end
  reg [7:0] empty [1:0];
  initial begin
    empty[0] = 8'h00;
    empty[1] = 8'h00;
  end
  initial state = 2'h3;
endmodule
"""


def test_a_memory_with_data_is_read_from_a_file() -> None:
    text, images = extract(MODULE)
    assert images == [Image("top__lane", "grid_27", 18, (0x0A1A2, 0x3F704, 0))]
    assert images[0].file == "top__lane.grid_27.hex"
    assert (images[0].facts["words"], images[0].facts["bits"]) == (3, 18)
    before, after = MODULE.splitlines(), text.splitlines()
    assert after == [*before[:2], '  initial $readmemh("top__lane.grid_27.hex", grid_27);', *before[7:]]


@st.composite
def images(draw: st.DrawFn) -> Image:
    """A memory of any shape with at least one bit set."""
    bits = draw(st.just(32) | st.integers(1, 150))
    words = draw(st.lists(st.integers(0, 2**bits - 1), min_size=1, max_size=20).filter(any))
    name = st.sampled_from(["a", "lane", "grid_27", "x0_1"])
    return Image("top__" + draw(name), draw(name), bits, tuple(words))


@given(st.lists(images(), max_size=4, unique_by=lambda image: image.file))
def test_any_memory_comes_back(expected: list[Image]) -> None:
    modules = []
    for image in expected:
        form = "d{}" if image.bits == 32 else f"h{{:0{-(-image.bits // 4)}x}}"  # as yosys writes them
        words = (f"{image.bits}'{form.format(word)}" for word in image.words)
        lines = [f"    {image.memory}[{n}] = {word};" for n, word in enumerate(words)]
        modules += [f"module {image.module}(clk);", "  initial begin", *lines, "  end", "endmodule", ""]
    text, found = extract("\n".join(modules))
    assert found == expected
    read = [f'  initial $readmemh("{image.file}", {image.memory});' for image in expected]
    assert [line for line in text.splitlines() if "initial" in line] == read


@pytest.mark.parametrize("wrong", [("[1] =", "[2] ="), ("18'h3f704", "18'bx"), ("18'h3f704", "18'h3x704")])
def test_words_that_are_not_understood_are_no_guesswork(wrong: tuple[str, str]) -> None:
    with pytest.raises(ValueError, match="top__lane, grid_27 are not understood"):
        extract(MODULE.replace(*wrong))


@pytest.mark.long
def test_a_core_keeps_every_word() -> None:
    """Coefficients against the model's own image; nothing but zeros is left in the text."""
    text, images = extract(to_verilog(DESIGN))
    mask = (1 << DESIGN.formats.coefficient) - 1
    found = {image.words for image in images}
    assert {tuple(int(word) & mask for word in row) for row in lane_images(DESIGN)} <= found
    assert len(images) == text.count("$readmemh") == DESIGN.architecture.mac_lanes + 1
    words = re.findall(r"^    \S+ ?\[\d+\] = \d+'h(\w+);", text, re.MULTILINE)
    assert words
    assert set("".join(words)) == {"0"}
