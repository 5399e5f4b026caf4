"""Colours of Okabe and Ito, which colour-blind readers can distinguish."""

BLUE, ORANGE, GREEN, VERMILION, PURPLE, BLACK = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#000000"
