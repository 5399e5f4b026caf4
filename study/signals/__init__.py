"""What flows inside the bit-accurate model: SQNR of stages, ranges, and how near bounds can be reached."""
