"""Form of the JSON sidecar: one pydantic model per object, whose descriptions become those of the JSON Schema.

A key ends in its unit: ``_m``, ``_pa``, ``_codes``, ``_bits``, ``_cycles``.  Keys without one hold names, counts and
texts.  ``python -m tfra.codegen.sidecar.schema`` prints the schema, which ``docs/core.schema.json`` publishes.
"""

import json
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, create_model

from tfra.model.choices import Images
from tfra.model.estimators import ESTIMATORS
from tfra.model.rounding import Overflow, Rounding
from tfra.model.sensor import sensor_keys

FORM: Literal["tfra-core-2"] = "tfra-core-2"
"""Changes when a key gets another name or meaning."""


class Part(BaseModel):
    """Immutable, no other keys; a part of a design becomes one by its attributes."""

    model_config = ConfigDict(extra="forbid", frozen=True, from_attributes=True)


Count = Annotated[int, Field(ge=0)]
Hash = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]

_SENSOR: dict[str, Any] = {
    key.si: (
        float if key.unit else int,
        Field(gt=0, validation_alias=key.field, description=key.meaning),
    )
    for key in sensor_keys()
}


class Sensor(create_model("_", __base__=Part, **_SENSOR)):  # type: ignore[misc]  # its fields are those of a table
    pass


class Converter(Part):
    bits: Annotated[int, Field(description="word length of a code, two's complement")]
    full_scale_pa: float = Field(
        validation_alias="full_scale", description="codes reach from -full_scale_pa to full_scale_pa - lsb_pa"
    )
    lsb_pa: float = Field(validation_alias="lsb", description="stress of one code; compression is negative")
    contact_threshold_codes: int = Field(
        validation_alias="threshold",
        description="a frame with all codes from -contact_threshold_codes to contact_threshold_codes - 1 is no contact",
    )


class Estimator(Part):
    kind: Literal[tuple(ESTIMATORS)]  # type: ignore[valid-type]  # the names of the registry
    units: Annotated[list[int] | None, Field(description="units of each layer of the network")] = None
    uncertainty_threshold: Annotated[
        float | None, Field(description="uncertainty over |f_z| from which a frame is IMPLAUSIBLE")
    ] = None
    uncertainty_threshold_word: Annotated[int | None, Field(description="what the core compares with: in 1/256")] = None
    taxel_forces: Annotated[bool | None, Field(description="whether the core computes the forces at the taxels")] = None


class Search(Part):
    steps: Annotated[int, Field(description="the sweep has steps + 1 candidates")]
    plateau_tolerance_codes: float = Field(validation_alias="tolerance")


class Formats(Part):
    name: str
    coefficient_bits: int = Field(validation_alias="coefficient")
    operand_bits: int = Field(validation_alias="operand")
    vector_fraction_bits: int = Field(validation_alias="vector_fraction")
    force_fraction_bits: int = Field(validation_alias="force_fraction")
    signals_bits: Annotated[dict[str, int], BeforeValidator(dict), Field(validation_alias="signals")]
    rounding: Annotated[Rounding, Field(description="of the results of products; all else is rounded half up")]


class Architecture(Part):
    kind: str
    mac_lanes: Annotated[int, Field(description="multiply-accumulate lanes; 0 for a serial core")]
    vector_words: Annotated[int, Field(description="words of a vector that move in a cycle; 0 for a serial core")]


class Bus(Part):
    taxels_per_beat: Annotated[int, Field(description="of the wrapper's input stream")]


class Port(Part):
    name: str
    direction: Literal["in", "out"]
    bits: Annotated[int, Field(ge=1)]
    note: str


class Load(Part):
    file: Annotated[str, Field(description="one word a line in hexadecimal, two's complement")]
    transfers: Count
    bits: Count
    order: str


class Taxels(Part):
    transfers_per_frame: Count
    bits: Annotated[int, Field(description="two's complement")]
    order: Literal["row-major"]
    lsb_pa: Annotated[float, Field(description="compression is negative")]


class ResultField(Part):
    name: str
    start: Annotated[int, Field(description="number of its first word in the frame, from 0")]
    count: Annotated[int, Field(description="words")]
    bits: Annotated[int, Field(description="the low bits of a transfer; those above repeat the sign, or are 0")]
    signed: bool
    fraction_bits: int
    overflow: Annotated[Overflow, Field(description="what becomes of a result that is too long for its word")]
    format: Annotated[str, Field(description="as fxpmath writes it")]
    unit: Annotated[str, Field(description="of the value; 1 is a number")]
    lsb: Annotated[float, Field(description="value of a word of 1, in `unit`")]
    uses_exponent: Annotated[bool, Field(description="whether the value is to be multiplied by 2^-exponent")]
    meaning: str


class StatusBit(Part):
    bit: Count
    name: str
    meaning: str


class Results(Part):
    transfers_per_frame: Count
    bits: Annotated[int, Field(description="of a transfer, two's complement")]
    fields: list[ResultField]
    status_bits: list[StatusBit]
    value: str


class Latency(Part):
    first_word: Annotated[int, Field(description="cycles to the transfer of the first result word")]
    last_word: Annotated[int, Field(description="cycles to the transfer of the last result word")]
    start: Annotated[str, Field(serialization_alias="from")]
    to: str


class Operator(Part):
    stack: str
    name: str
    quads: Count
    fraction_bits: int


class Coefficients(Part):
    sha256: Hash
    operators: list[Operator]


class Image(Part):
    file: Annotated[str, Field(description="one word a line in hexadecimal")]
    memory: str
    module: str
    words: Count
    bits: Count
    format: str


class Skin(Part):
    rows: Annotated[int, Field(description="taxels along y; those of `sensor` are of a window")]
    columns: Annotated[int, Field(description="taxels along x")]
    most_contacts: Annotated[int, Field(description="contacts of a frame that have a record")]
    threshold: Annotated[float, Field(description="height of the lowest peak over that of the frame's highest")]
    gap_taxels: Annotated[int, Field(description="taxels about a region that belong to no other contact")]
    marks: list[StatusBit]


class Sidecar(Part):
    """All that a program needs to use a generated core."""

    form: Literal["tfra-core-2"] = FORM
    generator: str
    name: str
    computes: str
    configuration_sha256: Annotated[Hash, Field(description="of all choices of the design")]
    skin: Annotated[Skin | None, Field(description="a larger array, whose contacts the core finds windows of")] = None
    sensor: Sensor
    adc: Converter
    estimator: Estimator
    search: Search | None = None
    formats: Formats
    architecture: Architecture
    target: Annotated[str, Field(description="family of devices")]
    memory_contents: Annotated[Images, Field(description="where the memories' contents come from")]
    bus: Bus
    widths_bits: Annotated[dict[str, int], Field(description="word lengths inside the core")]
    ports: list[Port]
    rules: dict[str, str]
    load: Annotated[Load | None, Field(description="what is loaded after every reset")] = None
    taxel: Taxels
    result: Results
    latency_cycles: Annotated[Latency, Field(description="of the core alone")]
    axi_latency_cycles: Annotated[Latency, Field(description="of the core in its wrapper, without repairs")]
    interval_cycles: Annotated[int, Field(description="from frame to frame, on average, when they come back to back")]
    multiplications_per_frame: int
    coefficients: Coefficients
    images: list[Image] = []
    tools: dict[str, str]

    def facts(self) -> dict[str, Any]:
        """As JSON has it, without what the core does not have."""
        return self.model_dump(by_alias=True, exclude_none=True)


def schema() -> str:
    """JSON Schema of the sidecar, as text."""
    found = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Sidecar.model_json_schema(by_alias=True, mode="serialization"),
    }
    return json.dumps(found, indent=1, sort_keys=True) + "\n"


if __name__ == "__main__":
    print(schema(), end="")
