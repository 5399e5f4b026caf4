"""Schema of a STUDY file, form only (:mod:`tfra.codegen.config.schema`); examples/study_hertz.toml explains every key.

Only ``config`` and ``[frames]`` are required.  Every section in the file is run; an empty one has its defaults.
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from tfra.codegen.config.schema import Section
from tfra.families import DEFAULT_PART
from tfra.study.frames.schema import FramesSection
from tfra.study.search.evaluate import QUANTITIES

SOME = Field(min_length=1, max_length=64)
Lengths = Annotated[list[Annotated[int, Field(ge=1, le=64)]], SOME]
Share = Annotated[float, Field(ge=0, le=1)]
Tolerance = Annotated[float, Field(ge=0, le=1e6)]


class UniformSection(Section):
    """``[uniform]``: designs whose coefficients and operands all have as many bits."""

    bits: Lengths = Field(default=[*range(8, 21)])


class ConverterSection(Section):
    """``[converter]``: every converter after every noise, the deviation of a taxel as a share of the frame's peak."""

    bits: Lengths = Field(default=[*range(8, 17)])
    noise_share_of_peak: Annotated[list[Share], SOME] = Field(default=[0.0, 0.0005, 0.001, 0.002, 0.005])


class SensitivitySection(Section):
    """``[sensitivity]``: every signal alone shorter by some bits."""

    shorter: Lengths = Field(default=[1, 2, 4])


class VariantsSection(Section):
    """``[variants]``: other steps of the sweep, other plateau tolerances, other rounding of products.

    Friction is found in steps of 1/K; tolerances are in LSB of the converter, summed over the array.
    """

    steps: Annotated[list[Annotated[int, Field(ge=1, le=4096)]], SOME] = Field(default=[10, 20, 50, 100, 200, 500])
    plateau_tolerance: Annotated[list[Tolerance], SOME] = Field(default=[0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0])


Names = Annotated[list[str], Field(min_length=1, max_length=16)]


class SearchSection(Section):
    """``[search]``: sufficient word lengths, for a part."""

    target: str = DEFAULT_PART
    costs: Names = Field(default=["coefficient_kbit", "DSP"])
    errors: Names = Field(default=[*QUANTITIES])
    give_up_percent: Annotated[float, Field(ge=0, le=1e6)] = 25.0
    generations: Annotated[int, Field(ge=1, le=10_000)] = 20
    size: Annotated[int, Field(ge=2, le=10_000)] = 24
    seed: Annotated[int, Field(ge=0)] = 1
    baseline: bool = True
    space: dict[str, Any] = Field(default={})


class VerifySection(Section):
    """``[verify]``: the designs of the search, in RTL, on held-out frames."""

    frames: Annotated[int, Field(ge=1, le=100_000)] = 200
    simulator: Literal["icarus", "verilator", "amaranth"] | None = None


class PlaceSection(Section):
    """``[place]``: the designs of the search, and those they are compared with, placed and routed on the target."""

    seeds: Annotated[int, Field(ge=1, le=99)] = 1
    clock_mhz: Annotated[float, Field(ge=1, le=1000)] | None = None


class StudyDocument(Section):
    """The whole file."""

    config: str
    beside: Annotated[list[str], Field(max_length=8)] = Field(default=[])
    frames: FramesSection
    uniform: UniformSection | None = None
    converter: ConverterSection | None = None
    sensitivity: SensitivitySection | None = None
    variants: VariantsSection | None = None
    search: SearchSection | None = None
    verify: VerifySection | None = None
    place: PlaceSection | None = None
