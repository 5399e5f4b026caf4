"""``datasheet.html``: all that an engineer needs who has the package alone, on one page that loads nothing."""

import json
import re
import zlib
from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

from tfra.codegen.package.accuracy import accuracy
from tfra.codegen.package.contents import Contents, template
from tfra.codegen.registers.files import register_table
from tfra.codegen.sidecar.build import core_ports
from tfra.codegen.sidecar.schema import Port
from tfra.codegen.verilog import testbench
from tfra.codegen.verilog.wrapper import ports_of
from tfra.families import FAMILIES, find
from tfra.hdl.bus.axi_lite import AxiLite
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.ip.framer import FAULTS, HEADER_WORDS, forces, version
from tfra.hdl.ip.wrapper import cut_through, interval, latencies, skin_interval, skin_latencies
from tfra.hdl.skin.timing import SkinTiming
from tfra.hdl.uart.bridge import WORD_BYTES
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import Field
from tfra.model.skin.records import result_layout, result_shape, results
from tfra.model.skin.scenes import recorded
from tfra.model.skin.skin import Skin
from tfra.recordings.facts import MEANINGS, status_label
from tfra.report.html import contents as links
from tfra.report.html import document
from tfra.report.table import Table

_COUNTED = ("LUT", "FF", "DSP", "BRAM")


def _ports(title: str, ports: Iterable[Port]) -> Table:
    rows = [(port.name, port.direction, port.bits, port.note) for port in ports]
    return Table(title, ("port", "", "bits", "meaning"), rows, (0, 1, 3))


def _output_words(contents: Contents) -> Table:
    """Every beat of an output frame, with the bits of each; of a skin, those of the first record."""
    errors = contents.registers["ERRORS"].fields
    fields = zip(result_layout(contents.array), contents.facts["result"]["fields"], strict=True)
    rows = [
        ("0", "15:0", "sequence", "", "1", "frames since a reset or soft reset, good or bad, from 0: a gap is a loss"),
        ("0", "31:16", "user", "", "1", "s_axis_tuser of the frame"),
        *((f"{HEADER_WORDS - 1}", f"{f.low}", f.name, "", "", f.text) for f in errors if f.name in FAULTS),
        ("1", "31:24", "format", "", "1", f"{version(contents.array)}: this format; all other bits of the beat are 0"),
        *(_word(field, facts) for field, facts in fields),
    ]
    return Table("Output frame", ("beat", "bits", "word", "format", "lsb", "meaning"), rows, (0, 1, 2, 3, 5))


def _word(field: Field, facts: dict[str, Any]) -> tuple[str, ...]:
    first = HEADER_WORDS + field.start
    beats = f"{first}" if field.count == 1 else f"{first} … {first + field.count - 1}"
    bits = f"{field.bits - 1}:0, {'sign' if field.signed else 'zeros'} above"
    unit = "" if field.unit == "1" else f" {field.unit}"
    return beats, bits, field.name, facts["format"], f"{field.lsb:.6g}{unit}", facts["meaning"]


def _example(array: Design | Skin) -> Table:
    """What the core makes of the first frame of its testbench: three words of each field at most, in units."""
    frames = recorded(array) if isinstance(array, Skin) else contact_codes(array, testbench.CONTACTS, testbench.SEED)
    (words,), layout = results(array, frames[:1]), result_layout(array)
    exponent = next(words[0, field.start] for field in layout if field.name.rpartition(".")[2] == "exponent")
    rows = []
    for field in layout:
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
    numbers = _of_skin(contents.array) if isinstance(contents.array, Skin) else _of_core(contents.core)
    rows = [(text, number, f"{contents.microseconds(number):,.2f}") for text, number in numbers.items()]
    return Table("Cycles", ("", "cycles", f"µs at {contents.clock_mhz:.1f} MHz"), rows)


def _of_skin(skin: Skin) -> dict[str, int]:
    """The most cycles of frames with as many contacts as there may be."""
    timing = SkinTiming.of(skin)
    first, last = skin_latencies(timing)
    return {
        "from s_axis_tlast to the first word of a record on m_axis": first,
        "from s_axis_tlast to m_axis_tlast": last,
        "from frame to frame, back to back": skin_interval(timing),
        "core alone: from its last taxel to its first word": timing.latency,
        "core alone: from its last taxel to its last word": timing.frame_latency,
        "core alone: from frame to frame": timing.interval,
    }


def _of_core(core: Microarchitecture) -> dict[str, int]:
    first, last, most_first, most_last = latencies(core)
    cut_first, cut_last = cut_through(core)
    return {
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


def datasheet(contents: Contents) -> dict[str, str]:
    """The page; raises ``InputError`` without the extra ``ip``."""
    count, accuracies = accuracy(contents.array)
    numbers = _numbers(contents) | {"contacts": count}
    rules, sensor = contents.facts["rules"].items(), contents.array.sensor
    values: dict[str, object] = {
        **{f"wave_{name}": f'<div class="wide" tabindex="0">{svg}</div>' for name, svg in _waves().items()},
        "wrapper_ports": _ports("Ports of the wrapper", ports_of(contents.array)),
        "core_ports": _ports("Ports of the core", core_ports(contents.array)),
        "output_words": _output_words(contents),
        "status_bits": _status(contents),
        "example": _example(contents.array),
        "cycles": _cycles(contents),
        "resources": _resources(contents),
        "placed": _placed(contents),
        "basis": escape(contents.part.basis),
        "counted": _counted(contents),
        "registers": register_table(contents.registers),
        "errors": accuracies,
        **numbers,
        **_sentences(contents, numbers),
        "contents": links(dict(re.findall(r'<h2 id="(\w+)">(.*)</h2>', template("datasheet.html")))),
        "blocks": contents.fill("blocks.svg"),
        "load": _load(contents),
        "pins": ",\n".join(f"    .{pin.name}({pin.name})" for pin in ports_of(contents.array)),
        "rules": "".join(f"<li><b>{escape(name)}</b>: {escape(text)}.</li>" for name, text in rules),
    }
    shown = {name: value.html() if isinstance(value, Table) else value for name, value in values.items()}
    body = contents.fill("datasheet.html", **shown)
    title = f"{contents.wrapper}: contact forces of {sensor.rows} × {sensor.columns} taxels"
    return {"datasheet.html": document(title, [body], template("datasheet.css"))}


def _status(contents: Contents) -> str:
    """Bits of the status, and of a skin's marks."""
    head = ("bit", "name", "meaning")
    flags = contents.design.status_bits
    status = [(f"{flag.bit_length() - 1}", status_label(flag), MEANINGS[flag]) for flag in flags]
    known = contents.facts.get("skin", {}).get("marks", ())
    marks = [(f"{mark['bit']}", mark["name"], mark["meaning"]) for mark in known]
    shown = Table("Status", head, status, (0, 1, 2)).html()
    return shown + f"<h3>Bits of marks</h3>\n{Table('Marks', head, marks, (0, 1, 2)).html()}" if marks else shown


def _sentences(contents: Contents, numbers: Mapping[str, object]) -> dict[str, str]:
    """Paragraphs of the page that are others for skins."""
    if isinstance(contents.array, Skin):
        filled = contents.fill("datasheet_skin.html", **numbers, **_skin_numbers(contents.array, contents))
    else:
        filled = contents.fill("datasheet_core.html", **numbers, **_core_numbers(contents))
    _, *parts = re.split(r"<!-- (\w+) -->\n", filled)
    return dict(zip(parts[::2], map(str.rstrip, parts[1::2]), strict=True))


def _numbers(contents: Contents) -> dict[str, object]:
    """Numbers and names of the page's sentences."""
    facts, design, sensor = contents.facts, contents.design, contents.array.sensor
    slots = design.bus.taxels_per_beat
    return {
        "hash": facts["configuration_sha256"],
        "computes": escape(facts["computes"]),
        "rows": sensor.rows,
        "columns": sensor.columns,
        "pitch": f"{1e3 * sensor.pitch_x:g} × {1e3 * sensor.pitch_y:g} mm",
        "taxels": sensor.taxels,
        "slots": slots,
        "beats": -(-sensor.taxels // slots),
        "bits": design.adc.bits,
        "lsb_pa": f"{design.adc.lsb:.6g}",
        "word_bytes": WORD_BYTES,
        "answer_cycles": AxiLite.latency,
        "architecture": design.architecture.kind,
    }


def _core_numbers(contents: Contents) -> dict[str, object]:
    """Those of sentences about a core of one result a frame."""
    core, words = contents.core, contents.design.frame_words
    first, last, most, _ = latencies(core)
    field = forces(contents.array)
    return {
        "output_beats": HEADER_WORDS + words,
        "short_beats": HEADER_WORDS + words - (field.count if field else 0),
        "rate": f"{1e6 / contents.microseconds(interval(core)):,.0f}",
        "first_us": f"{contents.microseconds(first):,.1f}",
        "most_us": f"{contents.microseconds(most):,.1f}",
        "apart": f"{last:,}",
        "shortest": f"{min(core.intervals):,}",
        "longest": f"{max(core.intervals):,}",
    }


def _skin_numbers(skin: Skin, contents: Contents) -> dict[str, object]:
    """Those of sentences about a skin."""
    timing, (words, _), field = SkinTiming.of(skin), result_shape(skin), forces(skin)
    _, last = skin_latencies(timing)
    rows, columns = skin.shape
    return {
        "most": skin.choices.most,
        "region": timing.taxels,
        "window_rows": rows,
        "window_columns": columns,
        "words": words,
        "short_words": words - (field.count if field else 0),
        "rate": f"{1e6 / contents.microseconds(skin_interval(timing)):,.0f}",
        "last_us": f"{contents.microseconds(last):,.1f}",
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
