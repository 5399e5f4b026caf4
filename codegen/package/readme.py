def readme(contents): return {}
