"""Proven bounds on the errors of fixed point."""
