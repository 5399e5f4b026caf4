"""Power of a core, an estimate: what the part takes at rest, and what registers and clock take at work.

At rest: typical supply currents of the core logic in Lattice's data sheets, of a part without activity at 25 °C: ECP5
Family (FPGA-DS-02012, Supply Current (Static)) and iCE40 UltraPlus (FPGA-DS-02008, table 4.6).

At work: the vendor has no table of energies, its calculator is a program.  So there are measurements of others instead:

* ECP5: chains of registers of which all change in every cycle, at the board's supply
  (https://github.com/targeted/fpga-reg-power, ``docs/power_data.ods``, at 100 MHz: 23.0 uW a register on an LFE5U-25F,
  25.1 uW on an LFE5U-85F, of which the larger counts).
* iCE40UP5K: counters at 12 MHz and 1.219 V (https://github.com/tinyvision-ai-inc/ice40_power): 613.5 uA with one of 28
  bits, 641.3 uA with seven more in 196 cells, of which each counter changes 2 bits a cycle; 85.6 uA with none.

Logic, multipliers and memories come on top, since nobody has published their energy: the sum is a lower bound.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tfra.families import Target

_REST_MW = {"ecp5-25": 77 * 1.1, "ecp5-85": 212 * 1.1, "ice40up5k": 0.075 * 1.2}
"""By part: current in mA times volts, of parts whose figure could be read again."""

_FLIP_PJ = {"ecp5": 25.1 / 100, "ice40": (641.3 - 613.5) * 1.219 / 12 / (7 * 2)}
"""By family: energy of a register that changes; of iCE40 with its lookup table, of ECP5 with its clock."""

_CLOCK_PJ = {"ecp5": 0.0, "ice40": (613.5 - 85.6) * 1.219 / 12}
"""By family: energy of the clock network in a cycle."""

TOGGLES = {"parallel": 0.064, "serial": 0.07}
"""Toggles of a register bit a cycle, frame after frame: means of the presets (``python -m bench.parts.toggles``)."""


@dataclass(frozen=True, slots=True)
class Power:
    """Milliwatts of the core supply: of the part at rest, and of registers and clock at work."""

    rest_mw: float
    registers_mw: float

    def __str__(self) -> str:
        sum_mw = self.rest_mw + self.registers_mw
        return f"{sum_mw:.3g} mW or more: {self.rest_mw:.3g} at rest, {self.registers_mw:.3g} registers and clock"


def power(used: Mapping[str, int], kind: str, clock_mhz: float, target: Target) -> Power | None:
    """Of a core of ``kind`` that takes ``used`` and computes frame after frame; None where nothing is published."""
    if target.part not in _REST_MW:
        return None
    family = target.family.name
    cycle_pj = _CLOCK_PJ[family] + used["FF"] * TOGGLES[kind] * _FLIP_PJ[family]
    return Power(_REST_MW[target.part], cycle_pj * clock_mhz / 1e3)
