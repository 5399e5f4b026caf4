"""Colours that colour-blind readers can distinguish: those of Okabe and Ito, and ColorBrewer's blue and red."""

BLUE, ORANGE, GREEN, VERMILION, PURPLE, BLACK = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#000000"

STRESS = (
    *("#053061", "#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7"),
    *("#fddbc7", "#f4a582", "#d6604d", "#b2182b", "#67001f"),
)
"""From compression, blue, through no stress to tension, red, in equal steps: of every map and surface of stress."""
