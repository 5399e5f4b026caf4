"""All files of a package, which drops into the FPGA project of a user; here those for tools, and the README."""

import json
import re
from collections.abc import Callable, Mapping
from importlib.metadata import files as installed
from importlib.resources import files
from typing import Any

from tfra.codegen.config.names import check_packaged
from tfra.codegen.config.write import config_text
from tfra.codegen.package.boards import boards
from tfra.codegen.package.contents import Contents, Part
from tfra.codegen.package.datasheet import datasheet
from tfra.codegen.package.drivers import driver_files
from tfra.codegen.package.ipxact import ipxact
from tfra.codegen.package.rules import placed, rules
from tfra.codegen.registers.files import register_files
from tfra.codegen.registers.source import parameters
from tfra.codegen.sidecar.build import LOADED
from tfra.codegen.sidecar.schema import schema
from tfra.codegen.verilog.axi_testbench import axi_testbench
from tfra.codegen.verilog.wrapper import input_bits, ports_of, wrapper_verilog
from tfra.families import FAMILIES, xilinx
from tfra.hdl.bus.map import Field, Register
from tfra.hdl.front_end.ports import NUMBER
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin

_ACCESS = {(True, True): "read-write", (True, False): "read-only", (False, True): "write-only"}
"""What software may do, as IP-XACT says it: whether it reads, whether it writes."""

_FILES = (
    ("datasheet.html", "everything about the core on one page: words, cycles, registers, resets, faults; begin here"),
    ("{name}_axi.v", "the core behind AXI4-Lite and AXI4-Stream: the module for a system on chip"),
    ("{name}.v", "the core alone, in one file of plain Verilog; its head states ports, rules and words"),
    ("{name}.json", "the same facts for programs"),
    (LOADED, "coefficients, loaded after every reset"),
    ("{name}.toml", "the configuration that all of this is made from; trained weights are a file of their own"),
    ("LICENSE", "of all of this"),
    ("errata.md", "what is wrong in this core, and was in earlier ones; CHANGELOG.md has all changes"),
    ("{name}.core", "FuseSoC: targets sim, sim_axi, lint and synth"),
    ("testbench/{name}_axi_tb.v", "checks {name}_axi in any simulator: every word; its head has a command"),
    ("testbench/{name}_tb.v", "checks every result word of the core alone"),
    ("core.schema.json", "JSON Schema of {name}.json: what each of its keys means"),
    ("driver/tfra_driver.h", "driver in C99: all its functions; example.c and show.h show how to use them"),
    ("driver/cosim.cpp", "co-simulation in C++: this driver with {name}_axi in Verilator; its head has the command"),
    ("python/tfra_host/__init__.py", "driver in Python; example.py shows how to use it"),
    ("registers/tfra.h", "registers for C"),
    ("registers/tfra.html", "registers, one by one"),
    ("{name}_async.v", "optional: {name}_axi, its streams with a clock of their own; its head has the constraints"),
    ("{name}_axi.vhd", "component of {name}_axi and constants of the design, for VHDL"),
    ("{name}_axi.xml", "IP-XACT of {name}_axi: buses, registers, ports, files"),
    ("constraints/{name}.sdc", "the clock, for tools that read SDC"),
    ("vivado/package_ip.tcl", "IP core for Vivado's catalogue: `vivado -mode batch -source vivado/package_ip.tcl`"),
    ("vivado/{name}_axi.xdc", "the clock, for Vivado"),
    ("litex/{name}.py", "a module for LiteX"),
    ("netlist/place.py", "places and routes with yosys and nextpnr as tfra synth does: the clock of the datasheet"),
    ("netlist/prepare.py", "what it does to a netlist between yosys and nextpnr, for a flow of your own"),
    ("boards/{board}/build.sh", "bitstream for the board {board}: the core behind its serial line"),
    ("boards/talk.py", "talks to the board: loads it, sends frames, compares the results"),
)


def origin(contents: Contents) -> dict[str, str]:
    """The design's configuration; the generator's errata, changes, and licence, which is that of what it copies."""
    skin = contents.array if isinstance(contents.array, Skin) else None
    weights = f"{contents.name}.weights.npz"
    config = config_text(contents.design, None, "Every key of the core.", weights, skin)
    (licence,) = (file.read_text() for file in installed("tfra") or () if file.name == "LICENSE")
    changes = files("tfra.codegen.package").joinpath("CHANGELOG.md").read_text("utf-8")
    errata = contents.fill("errata.md", hash=contents.facts["configuration_sha256"])
    return {f"{contents.name}.toml": config, "LICENSE": licence, "CHANGELOG.md": changes, "errata.md": errata}


def constraints(contents: Contents) -> dict[str, str]:
    """The clock's period in Synopsys' format, for the wrapper and for the core, whichever is the top module."""
    return {f"constraints/{contents.name}.sdc": contents.fill("constraints.sdc")}


def vivado(contents: Contents) -> dict[str, str]:
    """A script that packages the wrapper as an IP core, and its constraints; none for the cells of other families."""
    if contents.design.target in FAMILIES:
        return {}
    script = contents.fill(
        "package_ip.tcl",
        description=f"Computes {contents.facts['computes']}".replace('"', "'"),
        registers="".join(map(_register, contents.registers.registers)).rstrip(),
    )
    return {"vivado/package_ip.tcl": script, f"vivado/{contents.wrapper}.xdc": contents.fill("wrapper.xdc")}


def _register(register: Register) -> str:
    fields = "".join(map(_field, register.fields))
    kind = _ACCESS[register.readable, register.writable]
    return f"register {register.name} 0x{register.address:02X} {kind} {{{_braced(register.text)}}} {{\n{fields}}}\n"


def _field(field: Field) -> str:
    access = _ACCESS[field.kind.readable, field.kind.writable]
    return f"  {field.name} {field.low} {field.bits} {access} {{{_braced(field.text)}}}\n"


def _braced(text: str) -> str:
    """Text for Tcl's braces, which have to be in pairs."""
    return text.replace("{", "(").replace("}", ")").replace("\\", "/")


def litex(contents: Contents) -> dict[str, str]:
    """The wrapper as a module in Python that needs LiteX alone."""
    sources, images = (", ".join(f'"{name}"' for name in names) for names in (contents.rtl, contents.images))
    text = contents.fill("litex.py.txt", bits=input_bits(contents.array), sources=sources, images=images)
    return {f"litex/{contents.name}.py": text}


def vhdl(contents: Contents) -> dict[str, str]:
    """The wrapper's component in a package of VHDL (IEEE 1076-1993), with constants of the design."""
    stated = parameters(contents.array).items()
    numbers = {f"C_{name}": value for name, value in stated if not name.startswith("HASH")}
    numbers |= {f"AT_{register.name}": register.address for register in contents.registers.registers}
    constants = [f"  constant {name} : natural := {value};" for name, value in numbers.items()]
    digits = contents.facts["configuration_sha256"][:16]
    constants.append(f'  constant C_CONFIG_HASH : std_logic_vector(63 downto 0) := x"{digits}";')
    kinds = [(port, f"std_logic_vector({port.bits - 1} downto 0)") for port in ports_of(contents.array)]
    ports = [f"      {port.name} : {port.direction} {kind if port.bits > 1 else 'std_logic'}" for port, kind in kinds]
    text = contents.fill("component.vhd", constants="\n".join(constants), ports=";\n".join(ports))
    return {f"{contents.wrapper}.vhd": text}


def clock_crossing(contents: Contents) -> dict[str, str]:
    """The wrapper between FIFOs, for streams with a clock of their own."""
    ports = ports_of(contents.array)
    text = contents.fill(
        "async.v",
        declared=",\n".join(f"  {port.direction}put [{port.bits - 1}:0] {port.name}" for port in ports),
        pins=",\n".join(f"    .{port.name}({port.name})" for port in ports if "_axis_" not in port.name),
        in_top=input_bits(contents.array) + NUMBER,
    )
    return {f"{contents.name}_async.v": text}


def fusesoc(contents: Contents) -> dict[str, str]:
    """The package in CAPI2: targets ``default``, ``sim`` and ``sim_axi`` (Icarus), ``lint`` (Verilator), ``synth``."""
    family = FAMILIES.get(contents.design.target)
    flow, options = (family or xilinx.FAMILY).project
    if family:
        options = {**options, "nextpnr_options": [*contents.part.target.device]}
    rtl = [*contents.rtl, *(f"{name}: {{file_type: user, copyto: {name}}}" for name in contents.images)]
    text = contents.fill(
        "fusesoc.core",
        description=json.dumps(f"Computes {contents.facts['computes']}"),
        rtl=", ".join(rtl),
        modelled=", ".join([*rtl, *contents.cells]),
        flow=flow,
        options=json.dumps(options),
    )
    return {f"{contents.name}.core": text}


def readme(contents: Contents) -> dict[str, str]:
    """What each file is for, of those that are there, and the first commands."""
    board = contents.part.target.family.board
    names = {"name": contents.name, "board": board.name if board else ""}
    rows = [(file.format(**names), text.format(**names)) for file, text in _FILES]
    table = "\n".join(f"| `{file}` | {text} |" for file, text in rows if file in contents.texts)
    lines = contents.fill("README.md", board=names["board"], files=table).splitlines(keepends=True)
    return {"README.md": "".join(line for line in lines if _can_run(line, contents.texts))}


def _can_run(line: str, texts: Mapping[str, str]) -> bool:
    """Whether a line of the README is no command that runs a file which is not there."""
    script = re.match(r" {4}(?:sh|python3) (\S+)", line)
    return script is None or script[1] in texts


WRITERS: tuple[Callable[[Contents], dict[str, str]], ...] = (
    lambda contents: {f"{contents.wrapper}.v": wrapper_verilog(contents.array)},
    lambda contents: {f"testbench/{contents.wrapper}_tb.v": axi_testbench(contents.array)},
    lambda contents: {"core.schema.json": schema()},
    origin,
    lambda contents: register_files(contents.array),
    lambda contents: driver_files(contents.array),
    lambda contents: contents.cells,
    rules,
    placed,
    boards,
    constraints,
    vivado,
    litex,
    vhdl,
    clock_crossing,
    fusesoc,
    ipxact,
    datasheet,
    readme,
)
"""Each makes texts of files by their names, and sees those of the writers before it: some list the others' files."""


def package(array: Design | Skin, texts: Mapping[str, str], part: Part) -> dict[str, str]:
    """Texts of all files of a package by their names, those of ``texts`` not among them.

    Raises ``InputError`` without the packages of the extra ``ip``, and ``ValueError`` for a name that one of the
    languages keeps for itself.
    """
    check_packaged(array.name)
    facts: dict[str, Any] = json.loads(texts[f"{array.name}.json"])
    package: dict[str, str] = {}
    for write in WRITERS:
        package |= write(Contents(array, facts, {**texts, **package}, part))
    return package
