"""Signals inside the bit-accurate model: SQNR of stages, ranges, and attainable bounds."""
