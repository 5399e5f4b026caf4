"""Studies of errors: frame sets, errors taken apart, ranges, and the word lengths that are enough."""
