"""``datasheet.html``: all that an engineer needs who has the package alone, on one page that loads nothing."""

import json
import re
import zlib
from collections.abc import Iterable
from html import escape
from typing import Any

import numpy as np

from tfra.codegen.package.contents import Contents, template
from tfra.codegen.registers.files import register_table
from tfra.codegen.sidecar.build import core_ports
from tfra.codegen.sidecar.schema import Port
from tfra.codegen.verilog import testbench
from tfra.codegen.verilog.wrapper import ports_of
from tfra.families import FAMILIES, find
from tfra.hdl.bus.axi_lite import AxiLite
from tfra.hdl.ip.framer import FAULTS, HEADER_WORDS
from tfra.hdl.ip.wrapper import cut_through, interval, latencies
from tfra.hdl.uart.bridge import WORD_BYTES
from tfra.model.cover.scenes import contact_codes, known_contacts
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import Field
from tfra.model.fixed.words import decode
from tfra.model.metrics import errors
from tfra.recordings.facts import MEANINGS, status_label
from tfra.report.html import contents as links
from tfra.report.html import document
from tfra.report.table import Table

CONTACTS = 60
SEED = 1
"""Contacts of random shape, place, friction and direction, at 5 to 95 % of full scale, without noise."""

_COUNTED = ("LUT", "FF", "DSP", "BRAM")
_ERRORS = {"phi_deg": "φ / °", "mu_abs": "μ", "force_percent_of_resultant": "F / % of |F|"}


def _ports(title: str, ports: Iterable[Port]) -> Table:
    rows = [(port.name, port.direction, port.bits, port.note) for port in ports]
    return Table(title, ("port", "", "bits", "meaning"), rows, (0, 1, 3))


def _output_words(contents: Contents) -> Table:
    """Every beat of an output frame, with the bits of each."""
    errors = contents.registers["ERRORS"].fields
    fields = zip(contents.design.layout, contents.facts["result"]["fields"], strict=True)
    rows = [
        ("0", "15:0", "sequence", "", "1", "frames since a reset or soft reset, good or bad, from 0: a gap is a loss"),
        ("0", "31:16", "user", "", "1", "s_axis_tuser of the frame"),
        *((f"{HEADER_WORDS - 1}", f"{f.low}", f.name, "", "", f.text) for f in errors if f.name in FAULTS),
        ("1", "31:24", "format", "", "1", "1: this format; all other bits of the beat are 0"),
        *(_word(field, facts) for field, facts in fields),
    ]
    return Table("Output frame", ("beat", "bits", "word", "format", "lsb", "meaning"), rows, (0, 1, 2, 3, 5))


def _word(field: Field, facts: dict[str, Any]) -> tuple[str, ...]:
    first = HEADER_WORDS + field.start
    beats = f"{first}" if field.count == 1 else f"{first} … {first + field.count - 1}"
    bits = f"{field.bits - 1}:0, {'sign' if field.signed else 'zeros'} above"
    unit = "" if field.unit == "1" else f" {field.unit}"
    return beats, bits, field.name, facts["format"], f"{field.lsb:.6g}{unit}", facts["meaning"]


def _example(design: Design) -> Table:
    """What the core makes of the first frame of its testbench: three words of each field at most, in units."""
    words = design.model(contact_codes(design, testbench.CONTACTS, testbench.SEED)[:1]).words
    (exponent,) = next(words[:, field.start] for field in design.layout if field.name == "exponent")
    rows = []
    for field in design.layout:
        factor = field.lsb * 2.0 ** -int(exponent) if field.unit == "N" else field.lsb
        for start in range(field.start, field.start + min(field.count, 3)):
            word = int(words[0, start])
            beat = f"0x{word % (1 << 8 * WORD_BYTES):08X}"
            value = f"{word * factor:.6g} {field.unit.strip('1')}".strip()
            rows.append((HEADER_WORDS + start, field.name, beat, word, value))
    return Table("Example", ("beat", "word", "as it is sent", "number", "value"), rows, (1,))


def _counted(contents: Contents) -> str:
    """What tools of families that the estimates are not for have counted of portable Verilog, and how they count."""
    if contents.design.target in FAMILIES:
        return ""
    families = [family for family in FAMILIES.values() if not family.place_and_route]
    found = {name: row for name, row in contents.measurements.items() if not row["clock"]}
    used = {find(name).family.title: row["resources"] for name, row in found.items()}
    rows = [(title, *(row[name]["used"] for name in _COUNTED)) for title, row in used.items()]
    counts = Table("Other families", ("", *_COUNTED), rows).html() if rows else ""
    commands = {family.title: family.synthesis.format(top=contents.wrapper) for family in families}
    read = f"read_verilog {' '.join(contents.rtl)}"
    lines = "\n".join(f'yosys -p "{read}; {command}; stat"  # {title}' for title, command in commands.items())
    return f"<p>Core and wrapper on other families, as yosys counts them:</p>\n{counts}<pre>{escape(lines)}</pre>"


def _cycles(contents: Contents) -> Table:
    """Latency and interval, in cycles and µs at the part's clock."""
    core = contents.core
    first, last, most_first, most_last = latencies(core)
    cut_first, cut_last = cut_through(core)
    numbers = {
        "from s_axis_tlast to the first result word on m_axis, which is its beat 2": first,
        "from s_axis_tlast to m_axis_tlast": last,
        "the first of these with CONTROL.cut_through = 1, taxels without a pause": cut_first,
        "the second of these with CONTROL.cut_through = 1": cut_last,
        "to the first result word at most, frames back to back": most_first,
        "to m_axis_tlast at most, frames back to back": most_last,
        "from frame to frame, back to back, on average": interval(core),
        "core alone: from its last taxel to its first result word": core.latency,
        "core alone: from its last taxel to its last result word": core.frame_latency,
    }
    rows = [(text, number, f"{contents.microseconds(number):,.2f}") for text, number in numbers.items()]
    return Table("Cycles", ("", "cycles", f"µs at {contents.clock_mhz:.1f} MHz"), rows)


def _resources(contents: Contents) -> Table:
    """What the part has, and what is taken of it: as placed if that was measured, and as estimated."""
    measured = contents.measured
    head = ["", contents.part.target.name, "estimate for core and wrapper"]
    rows = [[name, have, used, f"{used / have:.0%}"] for name, (used, have) in contents.part.resources.items()]
    if measured:
        head += ["", f"placed: {measured['name']}"]
        used = {name: row["used"] for name, row in measured["resources"].items()}
        rows = [[*row, used[row[0]], f"{used[row[0]] / row[1]:.0%}"] for row in rows]
    return Table("Resources", (*head, ""), rows)


def _placed(contents: Contents) -> str:
    """How the clock is known, and how it is measured again."""
    found = contents.measured
    if found is None:
        return (
            f"This core was not placed: {contents.clock_mhz:g} MHz are what cores of its kind reach."
            " <code>python3 netlist/place.py</code> places it."
        )
    tools = ", ".join(f"{name} {version}" for name, version in found["tools"].items())
    seeds, asked = found["clock"]["seeds"], found["clock"]["asked_mhz"]
    speeds = ", ".join(f"{each['mhz']:.1f} MHz (seed {each['seed']})" for each in seeds)
    return (
        f"<code>{found['name']}</code> was placed and routed by {tools}, with a register and a pin at each port:"
        f" {speeds}. <code>python3 netlist/place.py SEED {asked:g}</code> repeats it."
        " The median is the clock of this page; in another place, among other logic, it can be less."
    )


def accuracy(design: Design) -> tuple[int, Table]:
    """How many contacts have a direction, and the errors of the bit-accurate model on these.

    Against double precision, and against the forces that were simulated.
    """
    contacts = known_contacts(design, CONTACTS, SEED)
    exact = design.float_model(contacts.codes * design.adc.lsb)
    fixed = decode(design, design.model(contacts.codes).words)
    clear = exact.status == 0
    against = {"double precision, same codes": errors(exact, fixed), "the simulated contact": errors(contacts, fixed)}
    rows = []
    for reference, by_name in against.items():
        for key, name in _ERRORS.items():
            median, high = np.percentile(by_name[key][clear], (50, 95)) if clear.any() else (0.0, 0.0)
            rows.append((reference, name, f"{median:.3g}", f"{high:.3g}"))
    return int(clear.sum()), Table("Accuracy", ("against", "error of", "median", "95th percentile"), rows, (0, 1))


def datasheet(contents: Contents) -> dict[str, str]:
    """The page; raises ``InputError`` without the extra ``ip``."""
    count, accuracies = accuracy(contents.design)
    rules, bits = contents.facts["rules"].items(), contents.design.status_bits
    status = [(f"{flag.bit_length() - 1}", status_label(flag), MEANINGS[flag]) for flag in bits]
    values: dict[str, object] = {
        **{f"wave_{name}": f'<div class="wide" tabindex="0">{svg}</div>' for name, svg in _waves().items()},
        "wrapper_ports": _ports("Ports of the wrapper", ports_of(contents.design)),
        "core_ports": _ports("Ports of the core", core_ports(contents.design)),
        "output_words": _output_words(contents),
        "status_bits": Table("Status", ("bit", "name", "meaning"), status, (0, 1, 2)),
        "example": _example(contents.design),
        "cycles": _cycles(contents),
        "resources": _resources(contents),
        "placed": _placed(contents),
        "basis": escape(contents.part.basis),
        "counted": _counted(contents),
        "registers": register_table(contents.registers),
        "errors": accuracies,
        **_numbers(contents),
        "contents": links(dict(re.findall(r'<h2 id="(\w+)">(.*)</h2>', template("datasheet.html")))),
        "blocks": contents.fill("blocks.svg"),
        "contacts": count,
        "load": _load(contents),
        "pins": ",\n".join(f"    .{pin.name}({pin.name})" for pin in ports_of(contents.design)),
        "rules": "".join(f"<li><b>{escape(name)}</b>: {escape(text)}.</li>" for name, text in rules),
    }
    shown = {name: value.html() if isinstance(value, Table) else value for name, value in values.items()}
    body = contents.fill("datasheet.html", **shown)
    sensor = contents.design.sensor
    title = f"{contents.wrapper}: contact forces of {sensor.rows} × {sensor.columns} taxels"
    return {"datasheet.html": document(title, [body], template("datasheet.css"))}


def _numbers(contents: Contents) -> dict[str, object]:
    """Numbers and names of the page's sentences."""
    facts, design = contents.facts, contents.design
    taxels, slots = design.sensor.taxels, design.bus.taxels_per_beat
    first, last, most, _ = latencies(contents.core)
    forces = next((field.count for field in design.layout if field.name == "forces"), 0)
    return {
        "hash": facts["configuration_sha256"],
        "computes": escape(facts["computes"]),
        "rows": design.sensor.rows,
        "columns": design.sensor.columns,
        "pitch": f"{1e3 * design.sensor.pitch_x:g} × {1e3 * design.sensor.pitch_y:g} mm",
        "taxels": taxels,
        "slots": slots,
        "beats": -(-taxels // slots),
        "bits": design.adc.bits,
        "lsb_pa": f"{design.adc.lsb:.6g}",
        "words": design.frame_words,
        "output_beats": HEADER_WORDS + design.frame_words,
        "short_beats": HEADER_WORDS + design.frame_words - forces,
        "word_bytes": WORD_BYTES,
        "answer_cycles": AxiLite.latency,
        "rate": f"{1e6 / contents.microseconds(interval(contents.core)):,.0f}",
        "first_us": f"{contents.microseconds(first):,.1f}",
        "most_us": f"{contents.microseconds(most):,.1f}",
        "apart": f"{last:,}",
        "shortest": f"{min(contents.core.intervals):,}",
        "longest": f"{max(contents.core.intervals):,}",
        "architecture": design.architecture.kind,
    }


def _waves() -> dict[str, str]:
    """Timing diagrams as SVG by their names, made of WaveDrom's signals in ``templates/waves.json``."""
    import wavedrom

    diagrams = {}
    for name, signals in json.loads(template("waves.json")).items():
        svg = wavedrom.render(json.dumps({"signal": signals, "config": {"hscale": 2}})).tostring()
        diagrams[name] = str(svg[svg.index("<svg") :])
    return diagrams


def _load(contents: Contents) -> str:
    """The steps, or that there are none."""
    words = contents.core.loaded
    if words is None:
        return "<p>None: the coefficients are in the core's memories from the start. LOAD_WORDS is 0.</p>"
    image = b"".join((int(word) & 0xFFFFFFFF).to_bytes(4, "little") for word in words)
    crc, bits = f"0x{zlib.crc32(image):08X}", contents.design.coefficient_word
    return contents.fill("datasheet_load.html", count=f"{len(words):,}", crc=crc, bits=bits)
