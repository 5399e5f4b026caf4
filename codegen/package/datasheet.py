"""``datasheet.html``: all that an engineer needs who has the package alone, on one page that loads nothing."""

import json
import re
import zlib
from html import escape

from tfra.codegen.package import sheettables as tables
from tfra.codegen.package.contents import Contents, fill, template
from tfra.codegen.registers.files import VENDOR, register_table
from tfra.codegen.verilog.wrapper import ports_of
from tfra.hdl.ip.framer import HEADER_WORDS
from tfra.hdl.uart.bridge import WORD_BYTES
from tfra.report.html import contents as links
from tfra.report.html import document

_TABLES = (
    tables.wrapper_ports,
    tables.core_ports,
    tables.output_words,
    tables.status_bits,
    tables.cycles,
    tables.resources,
)


def datasheet(contents: Contents) -> dict[str, str]:
    """The page; raises ``InputError`` without the extra ``ip``."""
    count, errors = tables.accuracy(contents.design)
    rules = contents.facts["rules"].items()
    values = {
        **{f"wave_{name}": f'<div class="wide" tabindex="0">{svg}</div>' for name, svg in _waves().items()},
        **{table.__name__: table(contents).html() for table in _TABLES},
        **_numbers(contents),
        "contents": links(dict(re.findall(r'<h2 id="(\w+)">(.*)</h2>', template("datasheet.html")))),
        "blocks": fill("blocks.svg", {"name": contents.name}),
        "registers": register_table(contents.registers).html(),
        "errors": errors.html(),
        "contacts": count,
        "load": _load(contents),
        "instance": escape(instance(contents)),
        "rules": "".join(f"<li><b>{escape(name)}</b>: {escape(text)}.</li>" for name, text in rules),
    }
    body = fill("datasheet.html", values)
    sensor = contents.design.sensor
    title = f"{contents.wrapper}: contact forces of {sensor.rows} × {sensor.columns} taxels"
    return {"datasheet.html": document(title, [body], template("datasheet.css"))}


def _numbers(contents: Contents) -> dict[str, object]:
    """Numbers and names of the page's sentences."""
    facts, design, part = contents.facts, contents.design, contents.part
    taxels, slots = design.sensor.taxels, design.bus.taxels_per_beat
    forces = next((field.count for field in design.layout if field.name == "forces"), 0)
    return {
        "name": contents.name,
        "wrapper": contents.wrapper,
        "vendor": VENDOR,
        "version": contents.version,
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
        "part": part.target.name,
        "mhz": f"{part.target.clock_mhz:g}",
        "basis": escape(part.basis),
        "rate": f"{1e6 * part.target.clock_mhz / facts['interval_cycles']:,.0f}",
        "first_us": f"{part.microseconds(facts['latency_cycles']['first_word']):,.1f}",
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
    values = {"count": f"{len(words):,}", "crc": f"0x{zlib.crc32(image):08X}", "bits": contents.design.coefficient_word}
    return fill("datasheet_load.html", values)


def instance(contents: Contents) -> str:
    """An instance of the wrapper in Verilog, with wires of the ports' names."""
    rows = ",\n".join(f"    .{pin.name}({pin.name})" for pin in ports_of(contents.design))
    return f"  {contents.wrapper} {contents.name}_0 (\n{rows}\n  );"
