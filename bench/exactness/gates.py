"""``make gates``: the gates of larger cores of every family against the model, a few frames each.

Synthesis of a 10 x 10 core takes minutes, and its gates run at some tens of cycles a second in Icarus.
"""

import sys
from dataclasses import replace

from tfra.families import FAMILIES
from tfra.model.choices import Architecture, Search
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray
from tfra.runtime.store import cache_directory
from tfra.sim.run import simulate
from tfra.synth.gates import synthesised

FRAMES = 3
DESIGNS = (
    TfraDesign(SensorArray(4, 4, 4e-3, 4e-3, 3e-3), "gates4", search=Search(8), architecture=Architecture(4)),
    TfraDesign(SensorArray(10, 10, 4e-3, 2e-3, 3e-3), "gates10", architecture=Architecture(16)),
)


def main() -> int:
    """Print a line for each core and family; 1 when a word differs or is missing."""
    wrong = 0
    for design in DESIGNS:
        codes = contact_codes(design, FRAMES, 1)
        words = FixedTfra(design)(codes).words
        for family in (name for name, family in FAMILIES.items() if family.gates):
            core = synthesised(replace(design, target=family), family, cache_directory())
            run = simulate(design, codes, "icarus", 1, "random", "random", expected=words, core=core)
            bad = run.mismatches + words.size - run.compared
            wrong += bad
            print(f"{design.name} on {family}: {run.compared} of {words.size} words compared, {run.mismatches} differ")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
