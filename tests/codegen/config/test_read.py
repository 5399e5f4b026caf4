"""CONFIG files: what they mean, and the one line that says what is wrong with them."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.model.learned.random_weights import random_weights
from tfra.codegen.config.read import LayerSpec, Project, load, load_tfra
from tfra.codegen.config.weights import Trained, write_weights
from tfra.model.choices import SERIAL, Adc, Architecture, Formats, Search
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.recordings.input import PLAIN, Input
from tfra.runtime.errors import InputError

EXAMPLES = Path(__file__).parents[3] / "examples"
CONFIGS = {path for path in EXAMPLES.glob("*.toml") if not path.stem.startswith("study_")}

SENSOR = """
[sensor]
rows = 10
columns = 10
pitch_x_mm = 4
pitch_y_mm = 2.0
thickness_mm = 3.0
"""

CONTACT = """
[[contact]]
shape = "hertz"
half_x_mm = 8
half_y_mm = 4
force_n = -5.73
mu = 0.5
phi_deg = 30
"""

GOOD = SENSOR + CONTACT


@pytest.fixture
def read(tmp_path: Path) -> Any:
    def read(text: str, name: str = "sensor.toml") -> Project:
        (tmp_path / name).write_text(text)
        return load(tmp_path / name)

    return read


@pytest.fixture
def complaint(read: Any, tmp_path: Path) -> Any:
    def complaint(text: str) -> str:
        with pytest.raises(InputError) as caught:
            read(text)
        return str(caught.value).removeprefix(f"{tmp_path}/")

    return complaint


# What a file means


def test_defaults(read: Any, tmp_path: Path) -> None:
    assert read(SENSOR) == Project(
        design=TfraDesign(SensorArray(10, 10, 0.004, 0.002, 0.003), name="sensor"),
        layer=LayerSpec(0.48, "point"),
        contacts=(),
        path=tmp_path / "sensor.toml",
    )


def test_every_section(read: Any) -> None:
    project = read(
        'name = "skin_7"\n'
        + SENSOR
        + "[adc]\nbits = 12\nfull_scale_pa = 5e4\ncontact_threshold_codes = 9\n"
        + "[search]\nsteps = 50\nplateau_tolerance = 2\n"
        + '[formats]\nname = "wide"\nforce_fraction_bits = 6\nsignals = {operand.force = 16, sums = 25}\n'
        + "[architecture]\nmac_lanes = 8\n"
        + '[target]\nname = "portable"\nimages = "readmemh"\n[layer]\npoisson = 0.3\nsampling = "area"\n'
    )
    assert project.layer == LayerSpec(0.3, "area")
    assert project.design == TfraDesign(
        sensor=SensorArray(10, 10, 0.004, 0.002, 0.003),
        name="skin_7",
        adc=Adc(12, 5e4, 9),
        search=Search(50, 2.0),
        formats=Formats("custom", 24, 24, 14, force_fraction=6, signals=(("operand.force", 16), ("sums", 25))),
        architecture=Architecture(mac_lanes=8),
        images="readmemh",
    )


def test_input(read: Any, tmp_path: Path) -> None:
    assert read(SENSOR).input == PLAIN
    text = SENSOR + '[input]\nunit = "codes"\ncompression = "positive"\ncoding = "offset"\ntare = "lab/rest.npy"\n'
    given = Input(unit="codes", compression="positive", coding="offset", tare=tmp_path / "lab" / "rest.npy")
    assert read(text).input == given
    text = SENSOR + '[input]\ntare_frames = 3\norder = "columns"\nflip_x = true\nskip_columns = 2\ntopic = "/t"\n'
    given = Input(tare_frames=3, order="columns", flip_x=True, skip_columns=2, topic="/t")
    assert read(text).input == given
    assert read(SENSOR + "[input]\nflip_y = true\n").input == Input(flip_y=True)
    assert read(SENSOR + '[input]\ntare = "/rest.npy"\n').input.tare == Path("/rest.npy")


LEARNED = '[estimator]\nkind = "learned"\nweights = "lab/w.npz"\n'


def test_estimator(read: Any, complaint: Any, tmp_path: Path) -> None:
    weights = random_weights(np.random.default_rng(0), 100, 3, 2)
    (tmp_path / "lab").mkdir()
    write_weights(tmp_path / "lab" / "w.npz", Trained(SensorArray(10, 10, 4e-3, 2e-3, 3e-3), weights, 0.25))
    found = read(SENSOR + LEARNED)
    assert found.weights == "lab/w.npz"
    assert isinstance(found.design, LearnedDesign)
    assert np.array_equal(found.design.weights.first, weights.first.astype(np.float32))
    assert (found.design.threshold, found.design.taxel_forces) == (0.25, True)
    short = read(SENSOR + LEARNED + "taxel_forces = false\n[formats.signals]\noperand.second = 14\n").design
    assert short.result_fields == tuple(name for name in found.design.result_fields if name != "forces")
    plain = load_tfra(tmp_path / "sensor.toml")
    assert (type(plain.design), plain.weights) == (TfraDesign, None)
    assert complaint(SENSOR + LEARNED + "[formats.signals]\ncoefficient.normal = 14\n") == (
        "sensor.toml: formats.signals.coefficient.normal: unknown signal, the nearest is coefficient.read2"
    )
    missing = complaint(SENSOR + LEARNED.replace("w.npz", "none.npz"))
    assert missing == "lab/none.npz: cannot be read: No such file or directory"


def test_contact_in_si_units(read: Any) -> None:
    """Its centre is that of the block, or given."""
    contact = Contact(ContactShape.HERTZ, 0.018, 0.009, 0.008, 0.004, -5.73, 0.5, math.radians(30))
    assert read(GOOD).contacts == (contact,)
    given = replace(contact, center_x=0.0155, center_y=0.01)
    assert read(f"{GOOD}center_x_mm = 15.5\ncenter_y_mm = 10\n{CONTACT}").contacts == (given, contact)


def test_millimetres_become_the_nearest_metres(read: Any) -> None:
    assert 0.03 / 1000 != 0.00003  # the naive way
    sensor = read(SENSOR.replace("pitch_x_mm = 4", "pitch_x_mm = 0.03")).design.sensor
    assert sensor.pitch_x == 0.00003


@pytest.mark.parametrize(
    ("phi", "degrees"),
    [
        ("-30.5", [-30.5]),
        ("[0, 45.0, 10]", [0, 45, 10]),
        ("{start = 0, stop = 60, step = 15}", [0, 15, 30, 45]),
        ("{start = 0, stop = 1, step = 0.1}", [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]),
        ("{start = 10, stop = -10, step = -8}", [10, 2, -6]),
    ],
)
def test_directions(read: Any, phi: str, degrees: list[float]) -> None:
    contacts = read(GOOD.replace("phi_deg = 30", f"phi_deg = {phi}")).contacts
    assert [c.phi for c in contacts] == [math.radians(d) for d in degrees]


@pytest.mark.parametrize(("rows", "columns", "lanes"), [(2, 2, 4), (3, 4, 16), (2, 5, 12), (10, 10, 16)])
def test_default_lanes_fit(read: Any, rows: int, columns: int, lanes: int) -> None:
    text = SENSOR.replace("rows = 10", f"rows = {rows}").replace("columns = 10", f"columns = {columns}")
    assert read(text).design.architecture.mac_lanes == lanes


def test_the_serial_core_chooses_its_own_lanes(read: Any) -> None:
    assert read(SENSOR + '[architecture]\nkind = "serial"').design.architecture == SERIAL
    assert read(SENSOR + '[architecture]\nkind = "parallel"').design == read(SENSOR).design


@pytest.mark.parametrize(
    ("file", "name"),
    [("skin.toml", "skin"), ("my skin-2.toml", "my_skin_2"), ("2skins.toml", "s_2skins"), ("é.toml", "s__")],
)
def test_name_follows_from_the_file(read: Any, file: str, name: str) -> None:
    assert read(SENSOR, file).design.name == name


@pytest.mark.parametrize("example", sorted(CONFIGS), ids=lambda path: path.stem)
def test_examples(example: Path) -> None:
    project = load(example)
    assert project.design.name == {"small": "small_core"}.get(example.stem, example.stem)
    contacts = {"hertz_40x20": 24, "rectangle_40x40": 24, "skin_8x12": 12, "fingers_32x32": 96}
    assert len(project.contacts) == contacts.get(example.stem, 0)
    assert project.design.sensor.taxels == (96 if example.stem == "skin_8x12" else 100)


# What can be wrong with it: keys of GOOD with other values, or more sections; and the line

WRONG = [
    # keys
    ("rows", "is missing"),
    ("rows = 10\nrow = 10", 'sensor.row: unknown key, the nearest valid key is "rows"'),
    ("[sensr]", 'unknown key, the nearest valid key is "sensor"'),
    ("mu = 0.5\nmy = 0.5", 'unknown key, the nearest valid key is "mu"'),
    ("mu", "is missing"),
    ('[estimator]\nkind = "learned"', 'estimator.weights: is missing: kind = "learned" needs a file of tfra train'),
    ("phi_deg = {start = 1, stop = 2}", "contact#1.phi_deg.step: is missing"),
    ("phi_deg = {stops = 2}", 'contact#1.phi_deg.stops: unknown key, the nearest valid key is "stop"'),
    # types
    ("rows = 10.0", "a whole number is needed, got 10.0"),
    ("pitch_x_mm = true", "a number is needed, got True"),
    ("shape = 1", "a text in quotes is needed, got 1"),
    ('phi_deg = [1, "x"]', "contact#1.phi_deg#2: a number is needed, got 'x'"),
    ("thickness_mm = nan", "a finite number is needed, got nan"),
    ("[input]\nflip_x = 1", "true or false is needed, got 1"),
    ("[formats.signals]\ncoefficient = 16", "a table is needed, got 16"),
    # sensor and contacts
    ("rows = 1", "at least 2 taxels are needed, got 1"),
    ("columns = 1", "at least 2 taxels are needed, got 1"),
    ("rows = 410", "at most 4096 taxels (rows x columns) are supported without a section window, got 4100"),
    ("thickness_mm = 1e9", "1000 or less is needed, got 1000000000.0"),
    ('shape = "round"', "one of hertz, uniform, rounded is needed, got 'round'"),
    ("half_x_mm = 0", "0.001 or more is needed, got 0"),
    ("half_x_mm = 21", "the footprint from -3 to 39 mm leaves the block from -2 to 38 mm"),
    ("mu = 0.5\ncenter_y_mm = 18", "the footprint from 14 to 22 mm leaves the block from -1 to 19 mm"),
    ("mu = -0.5", "a finite number >= 0 is needed, got -0.5"),
    ("mu = 1e9", "100 or less is needed, got 1000000000.0"),
    ("force_n = 5.73", "a negative (compressive), finite force is needed, got 5.73"),
    ("force_n = -1e99", "-1e+06 or more is needed, got -1e+99"),
    ("phi_deg = []", "at least one value is needed, got []"),
    ("phi_deg = {start = 0, stop = 9, step = -1}", "a step of -1 does not lead from 0 to 9"),
    ("phi_deg = {start = 0, stop = 9, step = 1e-9}", "at most 100000 directions are supported, got 9000000000"),
    # other sections
    ("[input]\ntare_frames = -1", "0 or more is needed, got -1"),
    ('[input]\ncoding = "signed"', "only codes have a coding: the unit must be codes, not Pa"),
    ("[adc]\nbits = 5", "6 to 20 is supported, got 5"),
    ("[adc]\nfull_scale_pa = -1", "0.001 or more is needed, got -1"),
    ("[adc]\ncontact_threshold_codes = -1", "0 to 8191, the largest code, is needed, got -1"),
    ("[search]\nsteps = 0", "1 to 4096 is supported, got 0"),
    ("[search]\nplateau_tolerance = -1", "zero or more is needed, got -1.0"),
    ('[formats]\nname = "huge"', "one of standard, wide is needed, got 'huge'"),
    ("[formats]\ncoefficient_bits = 5", "6 to 27 bits are supported, got 5"),
    ("[formats]\nforce_fraction_bits = -1", "0 to 16 bits are supported, got -1"),
    ("[formats]\noperand_bits = 12", "the 14-bit converter needs an operand of 14 bits or more"),
    ("[architecture]\nmac_lanes = 3", "a multiple of 4 up to 100 (4 parities x 25 quads) is needed, got 3"),
    ("[bus]\ntaxels_per_beat = 3", "1, 2 or 4 is needed, got 3"),
    ('[architecture]\nkind = "serail"', "one of parallel, serial is needed, got 'serail'"),
    ('[architecture]\nkind = "serial"\nmac_lanes = 4', "the serial core leaves nothing to choose, got 4"),
    ("[formats.signals]\nsum = 16", 'unknown key, the nearest valid key is "sums"'),
    ("[formats.signals]\ncoefficient.norm = 16", "unknown signal, the nearest is coefficient.normal"),
    ("[formats.signals]\noperand.force = 5", "6 to 27 bits are supported, got 5"),
    ("[formats.signals]\ncordic = 12", "at least 18 bits are needed beside the 18 of scalar, got 12"),
    (
        '[architecture]\nkind = "serial"\n[formats.signals]\nsums = 12',
        "a serial core has one multiplier and one memory for all signals: kind = parallel is needed",
    ),
    ('[target]\nname = "nexus"', "one of portable, ecp5, ice40 is needed, got 'nexus'"),
    ('[target]\nimages = "hex"', "'inline', 'readmemh' or 'load' is needed, got 'hex'"),
    (
        '[architecture]\nkind = "serial"\n[target]\nimages = "load"',
        "a serial core is always loaded: inline or readmemh, for its program, is needed",
    ),
    ('[estimator]\nkind = "best"', "'tfra' or 'learned' is needed, got 'best'"),
    ('[estimator]\nweights = "w.npz"', 'belongs to kind = "learned"'),
    ('[estimator]\nkind = "learned"\nweights = ""', "a name is needed, got ''"),
    ("[layer]\npoisson = 0.6", "a value in (-1, 0.5] is needed, got 0.6"),
    ('[layer]\nsampling = "line"', "'point' or 'area' is needed, got 'line'"),
    ('[layer]\nsolver = "magic"', "'series' or 'fem' is needed, got 'magic'"),
    ('[layer]\nsolver = "fem"\nsampling = "area"', "finite elements give the stress at points only"),
    ('[layer]\nsolver = "fem"\npoisson = 0.5', "finite elements need 0 <= nu < 0.5, got 0.5"),
]


@pytest.mark.parametrize(("wrong", "line"), WRONG, ids=[f"{wrong}: {line}" for wrong, line in WRONG])
def test_wrong_content(complaint: Any, wrong: str, line: str) -> None:
    """The line is about the last key of ``wrong``, if it does not say otherwise."""
    first, _, value = wrong.partition(" = ")
    text = GOOD + wrong if wrong.startswith("[") else re.sub(rf"(?m)^{first} = .*$", wrong if value else "", GOOD)
    sections, keys = re.findall(r"(?m)^\[(.+)\]$", wrong), re.findall(r"(?m)^([\w.]+)(?: =|$)", wrong)
    section = (sections or ["sensor" if f"\n{first} = " in SENSOR else "contact#1"])[-1]
    key = ".".join([section, *keys[-1:]])
    assert complaint(text) in (f"sensor.toml: {line}", f"sensor.toml: {key}: {line}")


@pytest.mark.parametrize("name", ["", "7up", "a b", "a-b", "a\\n", "x" * 64])
def test_wrong_name(complaint: Any, name: str) -> None:
    line = "sensor.toml: name: a letter, then at most 62 letters, digits and underscores are needed, got '"
    assert complaint(f'name = "{name}"\n{GOOD}').startswith(line)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "sensor: is missing"),
        ("sensor = 3", "sensor: a table is needed, got 3"),
        (f"contact = 3\n{SENSOR}", "contact: an array of tables, [[contact]], is needed, got 3"),
        ("[sensor]\nrows = = 3", "line 2, column 8: Invalid value"),
        ("[sensor]\nrows = 3\nrows = 4", "line 3: Cannot overwrite a value"),
        ("[sensor", "line 1: Expected ']' at the end of a table declaration"),
        ('\nname = """', 'line 2: Unterminated string'),
        ("a = " + "9" * 5000, "is not valid TOML"),
        ("a = " + "[" * 5000, "is not valid TOML"),
    ],
)
def test_malformed_text(complaint: Any, text: str, line: str) -> None:
    assert complaint(text) == f"sensor.toml: {line}"


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be read: Is a directory$"):
        load(tmp_path)
