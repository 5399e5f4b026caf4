"""``datasheet.html``: all that an engineer needs who has the package alone, on one page that loads nothing."""

import zlib
from html import escape
from string import Template

from tfra.codegen.package import sheettables as tables
from tfra.codegen.package.accuracy import accuracy
from tfra.codegen.package.contents import Contents, fill, template
from tfra.codegen.package.diagrams import waves
from tfra.codegen.registers.files import VENDOR
from tfra.codegen.registers.table import register_table
from tfra.codegen.verilog.wrapper import ports_of
from tfra.hdl.ip.framer import HEADER_WORDS
from tfra.hdl.uart.bridge import WORD_BYTES
from tfra.report.html import contents as links
from tfra.report.html import document

_SECTIONS = {
    "features": "Features",
    "ports": "Ports",
    "input": "Input frames",
    "output": "Output frames",
    "timing": "Handshakes and cycles",
    "resets": "Resets",
    "faults": "Faulty frames",
    "load": "Loading coefficients",
    "calibration": "Loading the calibration",
    "registers": "Registers",
    "resources": "Resources",
    "accuracy": "Accuracy",
    "integration": "Integration",
}


_TABLES = {
    "wrapper_ports": tables.wrapper_ports,
    "core_ports": tables.core_ports,
    "output_words": tables.output_words,
    "status_bits": tables.status_bits,
    "cycles": tables.cycles,
    "resources": tables.resources,
}


def datasheet(contents: Contents) -> dict[str, str]:
    """The page; raises ``InputError`` without the extra ``ip``."""
    count, errors = accuracy(contents.design)
    rules = contents.facts["rules"].items()
    values = {
        **{f"h_{name}": f'<h2 id="{name}">{title}</h2>' for name, title in _SECTIONS.items()},
        **{f"wave_{name}": f'<div class="wide" tabindex="0">{svg}</div>' for name, svg in waves().items()},
        **{name: make(contents).html() for name, make in _TABLES.items()},
        **_numbers(contents),
        "contents": links(_SECTIONS),
        "blocks": fill("blocks.svg", {"name": contents.name}),
        "registers": register_table(contents.registers).html(),
        "errors": tables.accuracies(errors).html(),
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
        "part": part.name,
        "mhz": f"{part.clock_mhz:g}",
        "basis": escape(part.basis),
        "rate": f"{1e6 * part.clock_mhz / facts['interval_cycles']:,.0f}",
        "first_us": f"{part.microseconds(facts['latency_cycles']['first_word']):,.1f}",
        "architecture": design.architecture.kind,
    }


def _load(contents: Contents) -> str:
    """The steps, or that there are none."""
    words = contents.core.loaded
    if words is None:
        return "<p>None: the coefficients are in the core's memories from the start. LOAD_WORDS is 0.</p>"
    image = b"".join((int(word) & 0xFFFFFFFF).to_bytes(4, "little") for word in words)
    values = {"count": f"{len(words):,}", "crc": f"0x{zlib.crc32(image):08X}", "bits": contents.design.coefficient_word}
    return fill("datasheet_load.html", values)


_INSTANCE = Template("  $wrapper $name (\n$pins\n  );")


def instance(contents: Contents) -> str:
    """An instance of the wrapper in Verilog, with wires of the ports' names."""
    rows = ",\n".join(f"    .{pin.name}({pin.name})" for pin in ports_of(contents.design))
    return _INSTANCE.substitute(wrapper=contents.wrapper, name=f"{contents.name}_0", pins=rows)
