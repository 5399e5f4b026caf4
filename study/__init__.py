"""Studies of errors: frame sets, errors by source, ranges, and sufficient word lengths."""
