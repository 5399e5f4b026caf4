"""The pictures of docs/view.md and docs/skins.md: pages of a contact that appears, turns and vanishes, by the float and
the bit-accurate model, and of four fingers on a skin.

``python -m docs.tools.picture`` draws ``docs/page.png`` and ``docs/skin.png`` in Chromium.
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
from tfra.skin import load_skin
from tfra.view.pack import Chosen
from tfra.view.page import render
from tfra.view.resultfile import Recorded, References

DOCS = Path(__file__).parents[1]
FRAMES = 181

TURNS = 60
"""Frames of the skin."""


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


def skin_page() -> str:
    """The page of four fingers of ``examples/fingers_32x32.toml``: one draws a line, one turns, two come and go."""
    skin = load_skin(DOCS.parent / "examples" / "fingers_32x32.toml")
    one, two, three, four = skin.contacts[0], *skin.contacts[-3:]
    frames = []
    for step, share in enumerate(np.linspace(0.0, 1.0, TURNS)):
        pressed = -2.0 * float(np.sin(np.pi * share))
        frames.append([
            replace(one, center_x=one.center_x + 21e-3 * float(share), phi=np.pi / 6),
            replace(two, phi=2 * np.pi * float(share)),
            *([replace(three, normal_force=pressed)] if pressed < -0.5 else []),
            *([four] if step > TURNS // 3 else []),
        ])
    stress, _ = skin.simulate(frames)
    return skin.estimate(stress, engine="fixed").view().html


PICTURES = {"page": (page, (1280, 3560)), "skin": (skin_page, (1280, 1930))}
"""Pages, and sizes of their pictures in pixels."""


def main() -> None:
    """Draw the pictures."""
    for name, (made, (width, height)) in PICTURES.items():
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "page.html"
            file.write_text(made(), encoding="utf-8")
            options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
            options += [f"--user-data-dir={folder}/p", f"--window-size={width},{height}"]
            picture = f"--screenshot={DOCS / name}.png"
            subprocess.run(["chromium", *options, picture, file.as_uri()], check=True, capture_output=True)


if __name__ == "__main__":
    main()
