"""Registers behind AXI4-Lite, built from a map that is plain data; they know nothing of any core."""
