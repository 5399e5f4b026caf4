"""Tables of the datasheet: ports, words, cycles, resources, and accuracy on simulated contacts."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from tfra.codegen.package.contents import Contents
from tfra.codegen.sidecar.build import core_ports as core_ports_of
from tfra.codegen.sidecar.schema import Port
from tfra.codegen.verilog.wrapper import ports_of, wrapper
from tfra.hdl.ip.framer import FAULTS, HEADER_WORDS
from tfra.model.cover.scenes import known_contacts
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import Field
from tfra.model.fixed.words import decode
from tfra.model.metrics import errors
from tfra.recordings.facts import MEANINGS, status_label
from tfra.report.table import Table

CONTACTS = 60
SEED = 1
"""Contacts of random shape, place, friction and direction, at 5 to 95 % of full scale, without noise."""

_ERRORS = {"phi_deg": "φ / °", "mu_abs": "μ", "force_percent_of_resultant": "F / % of |F|"}


def wrapper_ports(contents: Contents) -> Table:
    """Ports of NAME_axi."""
    return _ports("Ports of the wrapper", ports_of(contents.design))


def core_ports(contents: Contents) -> Table:
    """Ports of NAME."""
    return _ports("Ports of the core", core_ports_of(contents.design))


def _ports(title: str, ports: Iterable[Port]) -> Table:
    rows = [(port.name, port.direction, port.bits, port.note) for port in ports]
    return Table(title, ("port", "", "bits", "meaning"), rows, (0, 1, 3))


def output_words(contents: Contents) -> Table:
    """Every beat of an output frame, with the bits of each."""
    errors = contents.registers["ERRORS"].fields
    fields = zip(contents.design.layout, contents.facts["result"]["fields"], strict=True)
    rows = [
        ("0", "15:0", "sequence", "", "1", "frames that arrived since the reset, good or bad, from 0: a gap is a loss"),
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


def status_bits(contents: Contents) -> Table:
    """Bits of the word status."""
    flags = contents.design.status_bits
    rows = [(f"{flag.bit_length() - 1}", status_label(flag), MEANINGS[flag]) for flag in flags]
    return Table("Status", ("bit", "name", "meaning"), rows, (0, 1, 2))


def cycles(contents: Contents) -> Table:
    """Latency and interval, in cycles and µs at the part's clock."""
    facts, part = contents.facts, contents.part
    latency, added = facts["latency_cycles"], wrapper(contents.design).latency
    numbers = {
        "from s_axis_tlast to the first result word on m_axis, which is its beat 2": latency["first_word"] + added,
        "from s_axis_tlast to m_axis_tlast": latency["last_word"] + added,
        "from the core's last taxel to its first result word": latency["first_word"],
        "from the core's last taxel to its last result word": latency["last_word"],
        "from frame to frame, back to back": facts["interval_cycles"],
    }
    rows = [(text, number, f"{part.microseconds(number):,.2f}") for text, number in numbers.items()]
    return Table("Cycles", ("", "cycles", f"µs at {part.target.clock_mhz:g} MHz"), rows)


def resources(contents: Contents) -> Table:
    """What the core takes of its part."""
    part = contents.part
    rows = [(name, used, total, f"{100 * used / total:.0f} %") for name, (used, total) in part.resources.items()]
    return Table("Resources", ("", "core", part.target.name, ""), rows)


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
