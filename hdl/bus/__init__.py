"""Registers behind AXI4-Lite, made from a map that is plain data; they know nothing of any core."""
