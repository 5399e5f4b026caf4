"""Mutants of a core's netlist by yosys, which an input selects: their words are compared with those of the core in C,
the cycles of these with the original's.
"""

from dataclasses import dataclass
from pathlib import Path

from amaranth.back import rtlil

from bench.scorecard.mutants import equivalent
from bench.scorecard.words.harness import Configuration, built, ran
from bench.scorecard.words.measure import directed
from tfra.codegen.verilog.emit import Top, run_yosys
from tfra.hdl.cores import microarchitecture
from tfra.runtime.processes import ToolError

SOURCE = Path(__file__).with_name("mutants.cpp")
SEED, SELECT = 1, 12
"""Of the choice of mutants; bits of the input that selects one, 0 for none."""
CYCLES = (0, 30_000, 300_000)
"""Of random frames after the directed ones, for those that nothing was noticed of with fewer."""
_SCRIPT = """\
read_rtlil core.il
hierarchy -top {top}
proc -noopt -norom
pmuxtree
memory_collect
flatten
opt_clean
opt_expr
opt_clean
opt_merge
opt_clean
wreduce
opt_clean -purge
write_rtlil flat.il
mutate -list {count} -seed {seed} -o mutants -ctrl mutant {bits} 1
"""


@dataclass(frozen=True)
class Mutant:
    """A line of yosys' list, as words."""

    words: tuple[str, ...]

    def _after(self, option: str) -> list[str]:
        return [word for before, word in zip(self.words, self.words[1:], strict=False) if before == option]

    @property
    def number(self) -> int:
        """Value of the input that selects it."""
        return int(self.words[4])

    @property
    def clock(self) -> bool:
        """Whether it changes a clock."""
        return self._after("-port")[0].endswith("CLK")

    def __str__(self) -> str:
        """What is changed, and the lines that it comes from."""
        mode, port, bit = (self._after(option)[0] for option in ("-mode", "-port", "-portbit"))
        wire = "".join(f" of {name}" for name in self._after("-wire"))
        places = (place.partition("/tfra/")[2] for place in self._after("-src"))
        return f"{mode} {port}[{bit}]{wire}: {', '.join(filter(None, places))}"


class Mutants:
    """So many mutants of the core of ``configuration``, which is not behind AXI, built in the empty ``folder``."""

    def __init__(self, configuration: Configuration, folder: Path, count: int) -> None:
        self._folder, array = folder, configuration.array
        self._interval = microarchitecture(configuration.design).initiation_interval + array.sensor.taxels
        text = rtlil.convert(Top(array), name=array.name, emit_src=True)
        (folder / "core.il").write_text(str(text))
        run_yosys(_SCRIPT.format(top=array.name, count=count, seed=SEED, bits=SELECT), folder)
        lines = (folder / "mutants").read_text().splitlines()
        self.all = [one for one in (Mutant(tuple(line.split())) for line in lines) if not one.clock]
        self._applied(self.all, "write_verilog -noattr mutants.v")
        made = folder / "made_of"
        made.mkdir()
        texts = {**configuration.texts, f"{array.name}.v": (folder / "mutants.v").read_text()}
        cut = 3 * microarchitecture(configuration.design).frame_latency
        self._program = built(configuration, made, SOURCE, texts, options=["-CFLAGS", f"-DCUT={cut}"])
        (made / "given").write_bytes(directed(configuration).astype("<i4").tobytes())

    def _applied(self, mutants: list[Mutant], commands: str) -> None:
        """Run ``commands`` of yosys on the netlist with these mutants."""
        lines = ["read_rtlil flat.il", *(" ".join(one.words) for one in mutants), commands]
        (self._folder / "script.ys").write_text("\n".join(lines) + "\n")
        run_yosys("script script.ys", self._folder)

    def unnoticed(self, mutants: list[Mutant], cycles: int) -> list[Mutant]:
        """Those that send all words right and in time: of directed frames, and of random ones in so many ``cycles``.

        Raises ``ToolError`` where the original itself does not.
        """
        numbers, frames = [0, *(one.number for one in mutants)], cycles // self._interval
        found = {*map(int, ran(self._program, "./core.so", SEED, frames, "given", *numbers).split())}
        if 0 not in found:
            raise ToolError("mutants: the original's words are wrong")
        return [one for one in mutants if one.number in found]

    def unproven(self, mutants: list[Mutant]) -> list[Mutant]:
        """Those that are not proven to be equivalent to the original."""
        self._applied(mutants, equivalent.SCRIPT)
        prover = equivalent.Prover(equivalent.read(self._folder))
        return [one for one in mutants if not prover.equivalent(one.number)]
