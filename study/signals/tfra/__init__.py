"""Signals inside TFRA: their words, their float64 values, and the decisions between them."""
