"""Signals inside the learned estimator: their words, their float64 values, and the decisions between them."""
