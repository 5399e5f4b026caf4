"""A device to try drivers on: the registers of a design with a small model of the rest, in Verilog.

It has the ports of the wrapper ``NAME_axi``, so another file can take its place.
"""

import re
from pathlib import Path

from amaranth import Shape
from amaranth.lib.wiring import In

from tfra.codegen.registers.source import register_map
from tfra.codegen.registers.values import parameters
from tfra.codegen.verilog.emit import plain_verilog, to_rtlil
from tfra.codegen.verilog.wrapper import ports_of
from tfra.hdl.bus.bank import hardware_ports
from tfra.hdl.bus.registers import Registers
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

MODEL = Path(__file__).with_name("device.v")


def device(design: Design, words: Ints) -> dict[str, str]:
    """The module ``device`` and what it reads, by file: it plays the results ``words (n, frame_words)``."""
    registers, model = register_map(parameters(design)), MODEL.read_text()
    loaded = microarchitecture(design).loaded
    sizes = {"TAXELS": design.sensor.taxels, "WORDS": design.frame_words, "FRAMES": len(words)}
    sizes["FORCES"] = next(field.start for field in design.layout if field.name == "forces")
    sizes["LOAD_WORDS"] = 0 if loaded is None else loaded.size
    declared, wired = [f"localparam {name} = {value};" for name, value in sizes.items()], []
    for register in registers.registers:
        for field in register.fields:
            for name, port in hardware_ports(field).items():
                wire = f"{register.name}_{name}"
                declared.append(f"wire [{Shape.cast(port.shape).width - 1}:0] {wire};")
                wired.append(f".hardware__{register.name}__{name}({wire})")
                if port.flow == In and not re.search(rf"assign {wire}\b", model):
                    declared.append(f"assign {wire} = 0;")
    ports = ports_of(design)
    wired += [f".bus__{p.name.removeprefix('s_axi_')}({p.name})" for p in ports if p.name.startswith("s_axi_")]
    wired += [".clk(aclk)", ".rst(!aresetn)", ".interrupt(irq)"]
    instance = f"registers registers ({', '.join(wired)});"
    pins = ", ".join(f"{port.direction}put wire [{port.bits - 1}:0] {port.name}" for port in ports)
    body = "\n".join([f"module device({pins});", *declared, instance, model, "endmodule", ""])
    own = plain_verilog(to_rtlil(Registers(registers), "registers"), "registers")
    results = "".join(f"{int(word) & 0xFFFFFFFF:08x}\n" for word in words.ravel())
    return {"device.v": own + body, "results.hex": results}
