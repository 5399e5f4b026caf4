"""Points of the Verilog that a core's frames do not reach, each with its reason and with what reaches it instead."""

import re
from dataclasses import dataclass

from bench.scorecard.coverage.verilog import Point


@dataclass(frozen=True)
class Waiver:
    """Points whose block, kind and condition match the patterns, and the ``reason`` why they are not reached."""

    block: str
    kind: str
    condition: str
    reason: str

    def covers(self, point: Point) -> bool:
        """Whether it is about ``point``."""
        pairs = ((self.block, point.block), (self.kind, point.kind), (self.condition, point.condition))
        return all(re.fullmatch(pattern, text) for pattern, text in pairs)


WAIVERS = (
    Waiver(
        r"core__(registers|control|front_end|load)(__\w+)?",
        r"cond_then|cond_else|if|else",
        r".*",
        "registers, tables and faults of the front end: only traffic on AXI4-Lite and wrong frames reach it"
        " (tests/hdl/bus, tests/hdl/front_end, tests/hdl/ip, `make axi`)",
    ),
    Waiver(r"core__output", "cond_then", "abort", "a soft reset cuts a frame at the output (tests/hdl/ip)"),
    Waiver(
        r"core__framer",
        "cond_then",
        r"\(busy & o__payload_N\[N\]\)",
        "the end of a frame that is dropped (tests/hdl/ip)",
    ),
    Waiver(
        r".*",
        "cond_else",
        r"\(\(.*\[N:N\] == #\) \| \(& .*\[N:N\]\)\)",
        "a limit that no frame was found to exceed; bounds of signals are line 4",
    ),
    Waiver(
        r".*(dependent|share)",
        "cond_then",
        r"\(magnitude\[N\] & \(~ sign\)\)|\(\$signed\(o__payload_N\) > \$signed\(#\)\)",
        "a limit that no frame was found to exceed; bounds of signals are line 4",
    ),
    Waiver(
        r".*(fold|_facts|_fork|_sent|friction|resultant)",
        "cond_else",
        r"advance|\(& done\)|o__ready|chosen__ready|total__ready",
        "its receiver was never seen to stall in a core; the tests of the block alone stall it",
    ),
    Waiver(
        r".*divider",
        "cond_then",
        r"negative|i__payload\[N\]",
        "no dividend was found negative here (alone: tests/hdl/lib)",
    ),
    Waiver(
        r".*",
        "cond_else",
        r"\(+(masks|mask|maskN|magnitudes|work|total|frame_flags)(_?N)?\[N\].* #\)+|\(+(zeros|zeros_N|_N_) \|.*",
        "the last places of a search for the first one: no frame was found with so small a word (alone: tests/hdl/lib)",
    ),
)


def waived(point: Point) -> Waiver | None:
    """The first waiver of ``point``."""
    return next((waiver for waiver in WAIVERS if waiver.covers(point)), None)
