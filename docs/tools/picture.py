"""The picture of docs/view.md: a page of a contact that appears, turns and vanishes, by the float and the bit-accurate
model.

``python -m docs.tools.picture`` draws ``docs/page.png`` in Chromium.
"""

import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from tfra.codegen.config.read import load
from tfra.contacts import Truth
from tfra.model.converter import quantise
from tfra.model.fixed.words import decode
from tfra.model.tfra import Tfra
from tfra.view.pack import Chosen
from tfra.view.page import render
from tfra.view.resultfile import Recorded, References

DOCS = Path(__file__).parents[1]
FRAMES = 181

SIZE = 1280, 3040
"""Of the picture, in pixels."""


def page() -> str:
    """The page of one contact of ``examples/hertz_40x20.toml`` in all directions; its force comes and goes twice."""
    project = load(DOCS.parent / "examples" / "hertz_40x20.toml")
    design, angles = project.design, np.linspace(0.0, 2 * np.pi, FRAMES)
    contacts = tuple(replace(project.contacts[0], phi=float(angle)) for angle in angles)
    share = np.clip(np.sin(np.linspace(0.0, 3 * np.pi, FRAMES)), 0.0, None)
    frames = project.layer.frames(design.sensor, contacts) * share[:, None, None]
    true = Truth(contacts).arrays()
    known = {"phi_ref_deg": true["phi_ref_deg"], "mu_ref": true["mu_ref"]}
    known["resultant_ref"] = true["resultant_ref"] * share[:, None]
    codes, time = quantise(design, frames), 0.01 * np.arange(FRAMES)
    results = [
        Recorded("float.npz", "float", design, Tfra.of(design)(frames), frames, time),
        Recorded("fixed.npz", "fixed", design, decode(design, design.model(codes).words), codes * design.adc.lsb, time),
    ]
    return render(results, [References("frames.npz", known)], Chosen.of(results, range(FRAMES)))


def main() -> None:
    """Draw the picture."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        file.write_text(page(), encoding="utf-8")
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={folder}/p"]
        size = "--window-size={},{}".format(*SIZE)
        picture = f"--screenshot={DOCS / 'page.png'}"
        subprocess.run(["chromium", *options, size, picture, file.as_uri()], check=True, capture_output=True)


if __name__ == "__main__":
    main()
