"""Result words from the model's integers, and SI units from result words."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import fit
from tfra.model.tfra import Result

_BEAT = 32
"""Bits of a word behind a bus."""


def encode(design: Design, values: dict[str, Ints]) -> Ints:
    """Result frames ``(n, frame_words)`` from one array ``(n,)`` or ``(n, count)`` for each field, as its words fit."""
    columns = [fit(values[f.name].reshape(-1, f.count), f.bits, f.overflow) for f in design.layout]
    return np.concatenate(columns, axis=1)


def field(design: Design, words: Ints, name: str) -> Ints:
    """Words ``(n, count)`` of one field."""
    where = next(f for f in design.layout if f.name == name)
    return words[:, where.start : where.start + where.count]


def decode(design: Design, words: Ints) -> Result:
    """Result frames ``(n, frame_words)`` in SI units; forces at the taxels that a core does not send are NaN.

    Raises ``ValueError`` as :func:`received`.
    """
    return scaled(design, received(design, words))


def received(design: Design, words: Ints) -> Ints:
    """Result frames ``(n, frame_words)`` with negative words as such.

    A negative word may also be as it travelled: two's complement of ``design.word_bits`` or of 32 bits, read as
    unsigned.  No word of a signed field, which is no longer than these, can be meant by both.

    Raises ``ValueError`` for frames of another length, and for words that no core of ``design`` sends.
    """
    given = np.asarray(words)
    if given.ndim != 2 or given.shape[1] != design.frame_words or given.dtype.kind not in "iu":
        kind = f"{given.dtype} {given.shape}"
        raise ValueError(f"words: integers of frames of {design.frame_words} words are needed, got {kind}")
    if given.dtype == np.uint64 and given.size and given.max() > np.iinfo(np.int64).max:
        raise ValueError("words: a word exceeds 63 bits")
    signed = given.astype(np.int64)
    for where in design.layout:
        part = signed[:, where.start : where.start + where.count]
        low, high = (-1 << (where.bits - 1), 1 << (where.bits - 1)) if where.signed else (0, 1 << where.bits)
        if where.signed:
            for bits in {design.word_bits, max(design.word_bits, _BEAT)}:
                part[(part >= (1 << bits) + low) & (part < 1 << bits)] -= 1 << bits
        wrong = np.argwhere((part < low) | (part >= high))
        if len(wrong):
            frame, word = wrong[0]
            value = part[frame, word]
            raise ValueError(f"words: frame {frame}: {where.name} is from {low} to {high - 1}, got {value}")
    return signed


def scaled(design: Design, words: Ints) -> Result:
    """:func:`decode` of words as the bit-accurate model has them, which are not checked."""
    raw = {f.name: field(design, words, f.name) for f in design.layout}
    value = {f.name: np.multiply(raw[f.name], f.lsb, dtype=np.float64) for f in design.layout}
    count, scale = len(words), 2.0 ** -raw["exponent"]
    shape = (count, 3, design.sensor.rows, design.sensor.columns)
    return Result(
        forces=(value["forces"] * scale).reshape(shape) if "forces" in value else np.full(shape, np.nan),
        resultant=value["resultant"] * scale,
        phi_deg=value["phi"][:, 0],
        mu=value["mu"][:, 0],
        mu_x=value["mu_x"][:, 0],
        mu_y=value["mu_y"][:, 0],
        sweep_index=raw["sweep_index"][:, 0] if "sweep_index" in raw else np.full(count, -1, dtype=np.int64),
        status=raw["status"][:, 0],
        uncertainty=(value["uncertainty"] * scale)[:, 0] if "uncertainty" in value else None,
        threshold=design.uncertainty_threshold,
    )
