"""Tables of a search, and of the designs that came out of it, whose numbers are literal."""

from typing import Any

import polars as pl

from tfra.study.search.evaluate import CHANGE

FORCE, PHI = "force_difference_percent_of_true_force", "phi_deg"

TRIALS = [
    # Bits of the coefficients, errors of F and phi, kbit, LUT, on the front?
    (8, 14.0, 3.0, 80.0, 9_000.0, True),
    (12, 10.4, 2.0, 120.0, 10_000.0, True),
    (14, 10.4, 2.2, 140.0, 11_000.0, False),
    (18, 10.0, 2.0, 180.0, 13_000.0, True),
]


def growth(force: float, phi: float) -> float:
    """Percent over float's errors of 10 and 2, in the worse of both."""
    return round(max(10 * force, 50 * phi) - 100, 6)


def trials(rows: list[tuple[Any, ...]] = TRIALS) -> pl.DataFrame:
    """Trials of generations of two, and one behind them that does not fit."""
    chosen = [
        {"number": n, "generation": n // 2, "state": "complete", "coefficient": bits, FORCE: force, PHI: phi}
        | {CHANGE: growth(force, phi), "coefficient_kbit": kbit, "LUT": lut, "front": front, "reason": ""}
        for n, (bits, force, phi, kbit, lut, front) in enumerate(rows)
    ]
    nothing = dict.fromkeys([FORCE, PHI, CHANGE, "coefficient_kbit", "LUT"])
    unfit = {"number": len(rows), "generation": len(rows) // 2, "state": "unfit", "coefficient": 6}
    return pl.DataFrame([*chosen, unfit | nothing | {"front": False, "reason": "coefficient: too short"}])


def baseline() -> pl.DataFrame:
    return trials([(10, 12.0, 2.1, 100.0, 9_500.0, False), (16, 10.2, 2.0, 160.0, 12_000.0, False)])


def designs(**kbit: float) -> pl.DataFrame:
    """Float arithmetic, a placed design and some others; coefficients by name in kbit, negative where beyond."""
    unknown = {"coefficient_kbit": None, CHANGE: None}
    rows: list[dict[str, Any]] = [
        {"name": "float", "formats": "float64", FORCE: 10.0, PHI: 2.0, "within": True} | unknown,
        *(
            {"name": name, "formats": "words", FORCE: 10.1, PHI: 2.0, "within": size > 0}
            | {"coefficient_kbit": abs(size), CHANGE: growth(10.1, 2.0)}
            for name, size in kbit.items()
        ),
    ]
    placed = pl.col("name") == "mixed"
    return (
        pl.DataFrame(rows)
        .with_columns(pl.col(*unknown).cast(pl.Float64))
        .with_columns(
            LUT=pl.when(pl.col("coefficient_kbit").is_not_null()).then(10_500.0),
            placed_LUT=pl.when(placed).then(12_500.0),
            fmax_mhz=pl.when(placed).then(84.5),
            part=pl.when(placed).then(pl.lit("LFE5U-45F")),
            **{f"{name}_held_out": pl.col(name) + 0.5 for name in (FORCE, PHI, CHANGE)},
        )
    )
