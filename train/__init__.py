"""Training of the learned estimator: random loads, fast frames of the elastic layer, and the loop."""
