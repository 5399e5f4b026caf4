"""``vivado``: a script that packages the wrapper as an IP core, and its constraints."""

from tfra.codegen.package.constraints import timing
from tfra.codegen.package.contents import Contents, fill
from tfra.codegen.registers.files import VENDOR
from tfra.hdl.bus.map import Field, Register

_ACCESS = {(True, True): "read-write", (True, False): "read-only", (False, True): "write-only"}
"""What software may do, as IP-XACT says it: whether it reads, whether it writes."""


def vivado(contents: Contents) -> dict[str, str]:
    """``vivado/package_ip.tcl`` and ``vivado/NAME_axi.xdc``."""
    values = {
        **timing(contents),
        "wrapper": contents.wrapper,
        "vendor": VENDOR,
        "version": ".".join(contents.version.split(".")[:2]),
        "description": f"Computes {contents.facts['computes']}".replace('"', "'"),
        "images": " ".join(contents.images),
        "registers": "".join(map(_register, contents.registers.registers)).rstrip(),
    }
    return {
        "vivado/package_ip.tcl": fill("package_ip.tcl", values),
        f"vivado/{contents.wrapper}.xdc": fill("wrapper.xdc", values),
    }


def _register(register: Register) -> str:
    fields = "".join(map(_field, register.fields))
    kind = _ACCESS[register.readable, register.writable]
    return f'register {register.name} 0x{register.address:02X} {kind} {{{_braced(register.text)}}} {{\n{fields}}}\n'


def _field(field: Field) -> str:
    access = _ACCESS[field.kind.readable, field.kind.writable]
    return f"  {field.name} {field.low} {field.bits} {access} {{{_braced(field.text)}}}\n"


def _braced(text: str) -> str:
    """Text for Tcl's braces, which have to be in pairs."""
    return text.replace("{", "(").replace("}", ")").replace("\\", "/")
