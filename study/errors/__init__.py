"""Errors of results: by step, and their change with one choice."""
