"""The products of TFRA and what they wait for."""

from tfra.hdl.parallel.matvec.plan import Plan, Source

PLAN = Plan(
    (
        Source("vector", ("normal", "force"), 2, "bank_token"),
        Source("n", ("residual",), 2, "weight_token"),
        Source("b", ("contact",), 1),
    ),
    {"force": ("plane_token",), "contact": ("frame_token", "weight_token")},
)
"""A contact needs a place of its frame in all that follows, and a bank that its n will need; a product that gives
forces needs their planes."""
