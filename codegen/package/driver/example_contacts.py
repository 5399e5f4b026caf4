"""Calibrates the core of a skin, and prints the contacts of ten frames: ``python example.py REGISTERS FRAMES``.

REGISTERS is a device that maps them, such as ``/dev/uio0``; FRAMES gives output frames, one after the other: a device
of the DMA, or a file.
"""

import json
import sys
from pathlib import Path

from tfra_host import Core, FrontEnd, Mapped, parse_contacts, read_coefficients, read_contacts

SIDECAR = Path(__file__).resolve().parents[1] / "NAME.json"


def main(registers: str, frames: str) -> None:
    facts = json.loads(SIDECAR.read_text(encoding="utf-8"))
    core = Core(Mapped(registers), facts)
    if "load" in facts:
        core.load(read_coefficients(SIDECAR.parent / facts["load"]["file"], facts))
    core.set_front_end(FrontEnd(facts["adc"]["bits"], is_unsigned=False))  # True: offset binary
    core.tare(log2_frames=3)  # nothing may touch the sensor now
    core.wait_tare()
    with open(frames, "rb") as source:
        for _ in range(10):
            frame = parse_contacts(facts, read_contacts(facts, source))
            faults = ", ".join(sorted(frame.faults)) or "no"
            print(f"{frame.sequence}: {len(frame.contacts)} contacts, {frame.dropped} dropped, {faults} faults")
            for contact in frame.contacts:
                x, y, z = contact.window.resultant
                place = f"{contact.x:.4f} {contact.y:.4f} m"
                marks = ", ".join(sorted(contact.marks)) or "no"
                print(f"  at {place}: {x:.6f} {y:.6f} {z:.6f} N, friction {contact.window.mu:.3f}, {marks} marks")
    core.stop()


if __name__ == "__main__":
    main(*sys.argv[1:])
