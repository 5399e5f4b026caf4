"""Every name of a netlist becomes a plain identifier, and no two become one."""

from hypothesis import given
from hypothesis import strategies as st

from tfra.codegen.verilog.identifiers import with_plain_names

NETLIST = r"""
module \core.lane
  wire width 3 \word$1
  wire width 3 \word_1
  wire width 1 input 0 \wire
  memory width 3 size 4 \rom[0]
  cell $memrd_v2 $1
    parameter \MEMID "\\rom[0]"
    connect \DATA { \word$1 [2:1] \wire }
"""


def test_names_of_a_module() -> None:
    """A keyword, a name that is taken, a memory and the text that refers to it; slices and yosys' own names stay."""
    plain = NETLIST.replace("core.lane", "core__lane").replace("word$1", "word_1_2").replace(r"\wire", r"\n_wire")
    assert with_plain_names(NETLIST) == plain.replace("rom[0]", "rom_0")


@given(st.lists(st.text("ab1$_.[]", min_size=1), unique=True, max_size=8))
def test_names_stay_different(names: list[str]) -> None:
    renamed = with_plain_names("".join(f"\\{name} \\{name}\n" for name in names)).splitlines()
    assert len(set(renamed)) == len(names)
    for line in renamed:
        first, second = line.replace("\\", "").split()
        assert first == second
        assert first.isidentifier()
        assert first.isascii()
        assert not first.startswith("_")
