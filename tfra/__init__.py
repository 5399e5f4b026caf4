"""Contact forces from an array of normal-stress taxels, by the TFRA algorithm (doi:10.1016/j.mechatronics.2023.103070).

Describe the sensor once, in a CONFIG file (``tfra init`` writes one).  Then a recording becomes forces in five lines:

    >>> import tfra
    >>> sensor = tfra.load("examples/skin_8x12.toml")      # written by: tfra examples --out examples
    >>> frames, truth = sensor.simulate()                  # or recording = sensor.read("log.csv", unit="kPa")
    >>> result = sensor.estimate(frames, engine="fixed")   # bit by bit what the FPGA core computes
    >>> result.resultant.shape                             # F_x, F_y, F_z of every frame, in N
    (12, 3)
    >>> errors = result.errors(truth)                      # medians and 95th percentiles, when printed
    >>> result.save("forces.npz")                          # or .csv, .parquet
    >>> page = result.view("page.html")                    # an interactive page; needs tfra[view]

Stress is in Pa and negative under compression; forces are in N, lengths in m, directions in degrees (``_deg``).
A frame has the shape ``(rows, columns)``; taxel (i, j) sits at x = j * pitch_x, y = i * pitch_y.

Wrong input raises ``tfra.InputError``, a ``ValueError`` with a one-line message.  Suspicious but possible input, such
as a recording of the wrong sign, gives a result and a warning of the category ``tfra.Notice``.
"""

from __future__ import annotations

TYPE_CHECKING = False  # importing typing takes milliseconds, and every command imports this file
if TYPE_CHECKING:
    from tfra.contacts import Truth as Truth
    from tfra.found import Contacts as Contacts
    from tfra.model.cover.contact import Contact as Contact
    from tfra.model.cover.contact import ContactShape as ContactShape
    from tfra.model.tfra import Status as Status
    from tfra.recordings.frames import Recording as Recording
    from tfra.result import Errors as Errors
    from tfra.result import Page as Page
    from tfra.result import Result as Result
    from tfra.runtime.errors import InputError as InputError
    from tfra.runtime.errors import Notice as Notice
    from tfra.sensor import Sensor as Sensor
    from tfra.sensor import load as load
    from tfra.skin import Skin as Skin
    from tfra.skin import load_skin as load_skin

    __version__: str

_HOMES = {
    "Contact": "tfra.model.cover.contact",
    "Contacts": "tfra.found",
    "ContactShape": "tfra.model.cover.contact",
    "Errors": "tfra.result",
    "InputError": "tfra.runtime.errors",
    "Notice": "tfra.runtime.errors",
    "Page": "tfra.result",
    "Recording": "tfra.recordings.frames",
    "Result": "tfra.result",
    "Sensor": "tfra.sensor",
    "Skin": "tfra.skin",
    "Status": "tfra.model.tfra",
    "Truth": "tfra.contacts",
    "load": "tfra.sensor",
    "load_skin": "tfra.skin",
}
"""Modules that are imported at the first use of a name."""

__all__ = [*_HOMES, "__version__"]

if not TYPE_CHECKING:  # type checkers know the names and must report others

    def __getattr__(name):
        if name == "__version__":
            from importlib.metadata import version

            value = version("tfra")
        elif name in _HOMES:
            from importlib import import_module

            value = getattr(import_module(_HOMES[name]), name)
        else:
            raise AttributeError(f"module 'tfra' has no attribute {name!r}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
