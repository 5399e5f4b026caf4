"""Random scenes for verification and measurements: random contacts, and frames without contact."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Choices
from tfra.model.converter import Measured, quantise
from tfra.model.cover.contact import Contact, Contacts, ContactShape
from tfra.model.cover.layer import frames
from tfra.model.sensor import SensorArray

SENSORS = {
    "10×10, 4×2 mm, h 3 mm": SensorArray(10, 10, 4e-3, 2e-3, 3e-3),
    "10×10, 4×4 mm, h 3 mm": SensorArray(10, 10, 4e-3, 4e-3, 3e-3),
    "8×8, 2×2 mm, h 3 mm": SensorArray(8, 8, 2e-3, 2e-3, 3e-3),
    "5×7, 3×3 mm, h 2 mm": SensorArray(5, 7, 3e-3, 3e-3, 2e-3),
    "4×6, 5×3 mm, h 2 mm": SensorArray(4, 6, 5e-3, 3e-3, 2e-3),
    "16×16, 1×1 mm, h 1.5 mm": SensorArray(16, 16, 1e-3, 1e-3, 1.5e-3),
}
"""Sensors of many sizes, even and odd, well and less well conditioned, for tests and measurements."""

Seed = int | np.random.Generator
"""An argument of ``numpy.random.default_rng``; a generator continues from its state."""


def random_contacts(sensor: SensorArray, count: int, rng: np.random.Generator) -> list[Contact]:
    """Contacts of any shape, place, friction and direction that fit on the block.

    Half sizes are 12 to 30 % of the block's sides, F_z = -5 N, mu = 0.05 to 0.9.
    """
    contacts = []
    for _ in range(count):
        half_x, half_y = rng.uniform(0.12, 0.3) * sensor.size_x, rng.uniform(0.12, 0.3) * sensor.size_y
        x = rng.uniform(half_x, sensor.size_x - half_x) - sensor.pitch_x / 2
        y = rng.uniform(half_y, sensor.size_y - half_y) - sensor.pitch_y / 2
        shape = list(ContactShape)[rng.integers(len(ContactShape))]
        mu, phi = rng.uniform(0.05, 0.9), rng.uniform(0, 2 * np.pi)
        contacts.append(Contact(shape, x, y, half_x, half_y, -5.0, mu, phi))
    return contacts


def any_contacts(sensor: SensorArray, count: int, rng: np.random.Generator) -> Contacts:
    """Contacts from smaller than a cell to many cells: half sizes of 0.3 to 3 pitches, or 45 % of the block.

    Any shape and direction, anywhere on the block, F_z = -1 to -8 N, mu = 0 to 1.
    """
    pitch, size = np.array([sensor.pitch_x, sensor.pitch_y]), np.array([sensor.size_x, sensor.size_y])
    half = np.minimum(rng.uniform(0.3, 3, (count, 2)) * pitch, 0.45 * size)
    center = half - pitch / 2 + rng.random((count, 2)) * (size - 2 * half)
    mu, phi, normal = rng.uniform(0, 1, count), rng.uniform(0, 2 * np.pi, count), rng.uniform(1, 8, count)
    force = np.stack([mu * normal * np.cos(phi), mu * normal * np.sin(phi), -normal], axis=1)
    return Contacts(rng.choice([shape.value for shape in ContactShape], count), center, half, force)


def crowds(
    sensor: SensorArray, counts: Ints, rng: np.random.Generator, gap: float = 2.0, ratio: float = 5.0
) -> tuple[Contacts, Ints]:
    """Contacts of frames with ``counts (n,)`` each, and the number of the frame of every one.

    They are those of ``any_contacts`` with half sizes of up to 2 pitches, at least ``gap`` pitches apart along an axis,
    and F_z is -1 to -``ratio`` N.
    """
    pitch, size = np.array([sensor.pitch_x, sensor.pitch_y]), np.array([sensor.size_x, sensor.size_y])
    centers: list[Floats] = []
    halves: list[Floats] = []
    for count in counts:
        begun = len(centers)
        while len(centers) < begun + count:
            half = rng.uniform(0.3, 2, 2) * pitch
            center = half - pitch / 2 + rng.random(2) * (size - 2 * half)
            if (gaps(center, half, np.array(centers[begun:]), np.array(halves[begun:]), pitch) >= gap).all():
                centers.append(center)
                halves.append(half)
    total = len(centers)
    mu, phi, normal = rng.uniform(0, 1, total), rng.uniform(0, 2 * np.pi, total), rng.uniform(1, ratio, total)
    force = np.stack([mu * normal * np.cos(phi), mu * normal * np.sin(phi), -normal], axis=1)
    shapes = rng.choice([shape.value for shape in ContactShape], total)
    return Contacts(shapes, np.array(centers), np.array(halves), force), np.repeat(np.arange(len(counts)), counts)


def gaps(center: Floats, half: Floats, others: Floats, halves: Floats, pitch: Floats) -> Floats:
    """Pitches between an upright footprint and ``others (k, 2)``, along the axis where they are farther apart."""
    apart = np.abs(others.reshape(-1, 2) - center) - halves.reshape(-1, 2) - half
    return np.asarray((apart / pitch).max(axis=1))


def nearest(contacts: Contacts, frame: Ints, sensor: SensorArray) -> Floats:
    """Pitches ``(k,)`` from each footprint to the nearest other one of its frame, infinite where it is the only one.

    ``frame (k,)`` rises.
    """
    pitch = np.array([sensor.pitch_x, sensor.pitch_y])
    apart = np.full(len(frame), np.inf)
    for number, first in enumerate(np.searchsorted(frame, frame, "left")):
        others = np.arange(first, np.searchsorted(frame, frame[number], "right"))
        others = others[others != number]
        own = contacts.center[number], contacts.half[number]
        apart[number] = gaps(*own, contacts.center[others], contacts.half[others], pitch).min(initial=np.inf)
    return apart


def contact_codes(design: Choices, count: int, seed: Seed) -> Ints:
    """Converter codes ``(count, rows, columns)`` of random contacts, their peak at 10 to 95 % of full scale."""
    rng = np.random.default_rng(seed)
    return codes_of(design, frames(design.sensor, random_contacts(design.sensor, count, rng)), rng)


def codes_of(design: Choices, stress: Floats, rng: np.random.Generator) -> Ints:
    """Converter codes of ``stress (n, rows, columns)``, each frame's peak at 10 to 95 % of full scale."""
    peak = np.abs(stress).max(axis=(1, 2), keepdims=True)
    level = rng.uniform(0.1, 0.95, size=(len(stress), 1, 1)) * 2 ** (design.adc.bits - 1)
    return np.asarray(np.rint(stress / peak * level), dtype=np.int64)


@dataclass(frozen=True)
class KnownContacts:
    """Converter codes ``(n, rows, columns)`` of simulated contacts, with their true values."""

    codes: Ints
    resultant: Floats
    """``(n, 3)`` N."""
    mu: Floats
    phi_deg: Floats


def known_contacts(design: Choices, count: int, seed: Seed) -> KnownContacts:
    """``count`` random contacts without noise, their peak at 5 to 95 % of full scale."""
    rng = np.random.default_rng(seed)
    contacts = random_contacts(design.sensor, count, rng)
    stress = frames(design.sensor, contacts)
    scale = rng.uniform(0.05, 0.95, count) * design.adc.full_scale / np.abs(stress).max(axis=(1, 2))
    return KnownContacts(
        codes=quantise(design, stress * scale[:, None, None]),
        resultant=np.array([contact.force for contact in contacts]) * scale[:, None],
        mu=np.array([contact.mu for contact in contacts]),
        phi_deg=np.degrees([contact.phi for contact in contacts]),
    )


def wild_codes(array: Measured, count: int, seed: Seed) -> Ints:
    """Noise ``(count, rows, columns)`` of every amplitude and density: legal input without contact."""
    rng = np.random.default_rng(seed)
    top = 1 << (array.adc.bits - 1)
    shape, each = (count, array.sensor.rows, array.sensor.columns), (count, 1, 1)
    amplitude = 2.0 ** rng.uniform(0, array.adc.bits - 1, size=each)
    noise = rng.normal(size=shape) * amplitude * (rng.random(shape) < rng.uniform(0.05, 1, size=each))
    return np.clip(np.rint(noise), -top, top - 1).astype(np.int64)


def directed_codes(design: Choices) -> Ints:
    """Frames ``(n, rows, columns)`` for the corners of the input: silence, one sign only, extremes, single taxels,
    mirror symmetry (no direction), ramps, tiny amplitudes, and codes just within and beyond the contact threshold."""
    rng = np.random.default_rng(0)
    rows, columns = design.sensor.rows, design.sensor.columns
    low, high = -(1 << (design.adc.bits - 1)), (1 << (design.adc.bits - 1)) - 1
    i, j = np.indices((rows, columns))
    zero = np.zeros((rows, columns), dtype=np.int64)
    threshold = max(1, design.adc.threshold)
    even = (i + j) % 2 == 0
    edge = (i == 0) | (j == 0) | (i == rows - 1) | (j == columns - 1)

    def single(value: int, row: int, column: int, rest: int | Ints = 0) -> Ints:
        return np.where((i == row) & (j == column), value, rest)

    frames = [
        zero,
        zero + low,  # compression only, at full scale
        single(low, 0, 0),
        np.where(edge, high // 4, low // 2),  # no direction
        np.where(even, low, high),
        np.where(j < columns // 2, low, high),
        np.where(i < rows // 2, high, low),
        zero - 1,
        -rng.integers(0, high, zero.shape),
        zero + high,  # no contact at all
        rng.integers(0, high, zero.shape),
        single(high, rows - 1, columns - 1),
        single(-1, rows // 2, columns // 2),
        single(low, rows // 2, columns // 2, 1),
        single(low, 0, columns - 1, high),
        np.where(even, high, low),
        np.where(i % 2 == 0, low, high),
        np.where(edge, -1, 1),
        np.where(j > i, -1, 1),
        (j - columns // 2) * (high // columns),
        rng.integers(-1, 2, zero.shape),
        rng.integers(-1, 2, zero.shape),
        rng.integers(-4, 5, zero.shape),
    ]
    frames += [
        single(value, rows // 2, columns // 2, rng.integers(-threshold, threshold, zero.shape))
        for value in (-threshold, threshold - 1, -threshold - 1, threshold)
    ]
    return np.array(frames, dtype=np.int64)
