def datasheet(contents): return {}
