"""The map of the registers: ``python -m bench.parts.registers`` puts it into docs/registers.md."""

from __future__ import annotations

from bench.publish import insert
from tfra.codegen.registers.source import register_map
from tfra.codegen.registers.table import table

if __name__ == "__main__":
    insert("map", table(register_map({})), "docs/registers.md")
