"""The name of a core: a Verilog identifier that is neither a keyword nor the name of a port."""

import keyword
import re

KEYWORDS = frozenset(
    """
    accept_on alias always always_comb always_ff always_latch and assert assign assume automatic before begin bind bins
    binsof bit break buf bufif0 bufif1 byte case casex casez cell chandle checker class clocking cmos config const
    constraint context continue cover covergroup coverpoint cross deassign default defparam design disable dist do edge
    else end endcase endchecker endclass endclocking endconfig endfunction endgenerate endgroup endinterface endmodule
    endpackage endprimitive endprogram endproperty endsequence endspecify endtable endtask enum event eventually expect
    export extends extern final first_match for force foreach forever fork forkjoin function generate genvar global
    highz0 highz1 if iff ifnone ignore_bins illegal_bins implements implies import incdir include initial inout input
    inside instance int integer interconnect interface intersect join join_any join_none large let liblist library local
    localparam logic longint macromodule matches medium modport module nand negedge nettype new nexttime nmos nor
    noshowcancelled not notif0 notif1 null or output package packed parameter pmos posedge primitive priority program
    property protected pull0 pull1 pulldown pullup pulsestyle_ondetect pulsestyle_onevent pure rand randc randcase
    randsequence rcmos real realtime ref reg reject_on release repeat restrict return rnmos rpmos rtran rtranif0
    rtranif1 s_always s_eventually s_nexttime s_until s_until_with scalared sequence shortint shortreal showcancelled
    signed small soft solve specify specparam static string strong strong0 strong1 struct super supply0 supply1
    sync_accept_on sync_reject_on table tagged task this throughout time timeprecision timeunit tran tranif0 tranif1 tri
    tri0 tri1 triand trior trireg type typedef union unique unique0 unsigned until until_with untyped use uwire var
    vectored virtual void wait wait_order wand weak weak0 weak1 while wildcard wire with within wor xnor xor
    """.split()  # noqa: SIM905  # a list of literals would take 250 lines
)
"""Keywords of SystemVerilog, IEEE 1800-2017 Annex B; those of Verilog, IEEE 1364-2005 Annex B, are among them."""

SIMULATORS = frozenset({"bool", "std", "wone", "wreal"})
"""Keywords of Icarus and Verilator beyond the standard."""

_VHDL = """
abs access after alias all and architecture array assert assume attribute begin block body buffer bus case component
configuration constant context cover default disconnect downto else elsif end entity exit fairness file for force
function generate generic group guarded if impure in inertial inout is label library linkage literal loop map mod nand
new next nor not null of on open or others out package parameter port postponed procedure process property protected
private pure range record register reject release rem report restrict return rol ror select sequence severity shared
signal sla sll sra srl strong subtype then to transport type unaffected units until use variable view vmode vpkg vprop
vunit wait when while with xnor xor
"""
_C = """
alignas alignof auto bool break case char const constexpr continue default do double else enum extern false float for
goto if inline int long nullptr register restrict return short signed sizeof static static_assert struct switch
thread_local true typedef typeof typeof_unqual union unsigned void volatile while
"""
_TCL = """
after append apply array break catch close concat continue default dict else elseif error eval exec exit expr file for
foreach format global if incr info join lappend lindex linsert list llength lrange lreplace lsearch lset lsort
namespace open package proc puts regexp regsub rename return scan set source split string subst switch then time trace
unset uplevel upvar variable while
"""

PACKAGED = {
    "VHDL": frozenset(_VHDL.split()),
    "C": frozenset(_C.split()),
    "Python": frozenset(keyword.kwlist),
    "Tcl": frozenset(_TCL.split()),
}
"""Words of the languages in which a package is used: VHDL (IEEE 1076-2019), C (C23), Python, Tcl's commands."""

PORTS = frozenset(
    {
        *("clk", "rst", "taxel_data", "taxel_valid", "taxel_ready", "load_data", "load_valid", "load_ready"),
        *("result_data", "result_last", "result_valid", "result_ready"),
    }
)
"""Ports of the top module; Verilator confuses them with a module of the same name."""

_INNER = "__core"
"""What follows a core's name in those of its modules; without it, cores of different names share no module."""

_LONGEST_STEM = 60


def name_from(stem: str) -> str:
    """Make the ``stem`` of a CONFIG file a name; raises ``ValueError`` (``name: ...``) for a word that is taken."""
    name = re.sub(r"[^A-Za-z0-9_]", "_", stem)[:_LONGEST_STEM]
    name = name if name[:1].isalpha() else f"s_{name}"
    if word := _taken(name):
        raise ValueError(f'name: is missing, and the file\'s own, "{name}", is {word}: set another one')
    return name


def checked(name: str) -> str:
    """Return ``name``; raises ``ValueError`` (``name: ...``) for a word that is taken."""
    if word := _taken(name):
        raise ValueError(f'name: "{name}" is {word}')
    return name


def check_packaged(name: str) -> None:
    """Raise ``ValueError`` (``name: ...``) for a word that one of a package's languages keeps for itself.

    VHDL knows no case, and has no names with two underscores in a row or one at the end.
    """
    for language, words in PACKAGED.items():
        if (name.lower() if language == "VHDL" else name) in words:
            raise ValueError(f'name: "{name}" is a keyword of {language}, which a package is used in')
    if "__" in name or name.endswith("_"):
        raise ValueError(f'name: "{name}" is no name in VHDL, which has no "__" and no "_" at the end')


def _taken(name: str) -> str:
    if name in KEYWORDS:
        return "a keyword of Verilog"
    if name in SIMULATORS:
        return "a keyword of Verilog simulators"
    if _INNER in name:
        return "like a module inside of a core"
    return "a port of the core" if name in PORTS else ""
