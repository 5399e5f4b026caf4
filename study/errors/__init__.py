"""Errors of results: taken apart by step, and how they change when one choice does."""
