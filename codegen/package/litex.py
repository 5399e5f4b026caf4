"""``litex/NAME.py``: the wrapper as a LiteX module."""

from tfra.codegen.package.contents import Contents, fill
from tfra.codegen.verilog.wrapperports import input_bits


def litex(contents: Contents) -> dict[str, str]:
    """A Python module that needs LiteX alone."""
    values = {
        "name": contents.name,
        "wrapper": contents.wrapper,
        "bits": input_bits(contents.design),
        "sources": ", ".join(f'"{name}"' for name in (f"{contents.name}.v", f"{contents.wrapper}.v")),
        "images": ", ".join(f'"{name}"' for name in contents.images),
    }
    return {f"litex/{contents.name}.py": fill("litex.py.txt", values)}
