"""One page to look at results: maps, a surface, the sweep, and what changes over the frames."""
