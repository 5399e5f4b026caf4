"""Schema of a STUDY file, form only (:mod:`tfra.codegen.config.schema`); examples/study_hertz.toml explains every key.

Only ``config`` and ``[frames]`` are required.  Every section in the file is run; an empty one has its defaults.
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from tfra.codegen.config.schema import Section
from tfra.families import DEFAULT_PART
from tfra.study.errors.comparisons import CONVERTER_BITS, CONVERTER_NOISE, SHORTER, STEPS, TOLERANCES, UNIFORM
from tfra.study.frames.schema import FramesSection
from tfra.study.search.evaluate import QUANTITIES

Lengths = Annotated[list[Annotated[int, Field(ge=1, le=64)]], Field(min_length=1, max_length=64)]
Share = Annotated[float, Field(ge=0, le=1)]
Tolerance = Annotated[float, Field(ge=0, le=1e6)]


class UniformSection(Section):
    """``[uniform]``: designs whose coefficients and operands all have as many bits."""

    bits: Lengths = Field(default_factory=lambda: list(UNIFORM))


class ConverterSection(Section):
    """``[converter]``: every converter after every noise."""

    bits: Lengths = Field(default_factory=lambda: list(CONVERTER_BITS))
    noise_share_of_peak: Annotated[list[Share], Field(min_length=1, max_length=64)] = Field(
        default_factory=lambda: list(CONVERTER_NOISE)
    )


class SensitivitySection(Section):
    """``[sensitivity]``: every signal alone shorter by some bits."""

    shorter: Lengths = Field(default_factory=lambda: list(SHORTER))


class VariantsSection(Section):
    """``[variants]``: other steps of the sweep, other plateau tolerances, other rounding of products."""

    steps: Annotated[list[Annotated[int, Field(ge=1, le=4096)]], Field(min_length=1, max_length=64)] = Field(
        default_factory=lambda: list(STEPS)
    )
    plateau_tolerance: Annotated[list[Tolerance], Field(min_length=1, max_length=64)] = Field(
        default_factory=lambda: list(TOLERANCES)
    )


Names = Annotated[list[str], Field(min_length=1, max_length=16)]


class SearchSection(Section):
    """``[search]``: sufficient word lengths, for a part."""

    target: str = DEFAULT_PART
    costs: Names = Field(default_factory=lambda: ["coefficient_kbit", "DSP"])
    errors: Names = Field(default_factory=lambda: list(QUANTITIES))
    give_up_percent: Annotated[float, Field(ge=0, le=1e6)] = 25.0
    generations: Annotated[int, Field(ge=1, le=10_000)] = 20
    size: Annotated[int, Field(ge=2, le=10_000)] = 24
    seed: Annotated[int, Field(ge=0)] = 1
    baseline: bool = True
    space: dict[str, Any] = Field(default_factory=dict)


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
    frames: FramesSection
    uniform: UniformSection | None = None
    converter: ConverterSection | None = None
    sensitivity: SensitivitySection | None = None
    variants: VariantsSection | None = None
    search: SearchSection | None = None
    verify: VerifySection | None = None
    place: PlaceSection | None = None
