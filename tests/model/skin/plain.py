"""Finding as a person would do it with a pencil: plain loops and fractions, to check the model with."""

from fractions import Fraction
from math import floor
from typing import NamedTuple

Grid = list[list[int]]
Taxel = tuple[int, int]


class Plain(NamedTuple):
    """A contact: its region, the middle of that in taxels, and the first row and column of its window."""

    region: set[Taxel]
    middle: tuple[Fraction, Fraction]
    corner: Taxel
    touching: bool


def smoothed(grid: Grid) -> Grid:
    """The compression of ``grid``, weighted by 1 2 1 along both axes."""
    rows, columns = len(grid), len(grid[0])

    def at(row: int, column: int) -> int:
        inside = 0 <= row < rows and 0 <= column < columns
        return -grid[row][column] if inside else 0

    def total(row: int, column: int) -> int:
        near = ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1))
        return sum((2 - abs(i)) * (2 - abs(j)) * at(row + i, column + j) for i, j in near)

    return [[max(0, total(row, column)) for column in range(columns)] for row in range(rows)]


def contacts(
    grid: Grid, window: Taxel, most: int, threshold: Fraction, gap: int, least: int
) -> tuple[list[Plain], int]:
    """Contacts of ``grid``, and the number of peaks that are left."""
    smooth = smoothed(grid)
    height = {(r, c): value for r, row in enumerate(smooth) for c, value in enumerate(row)}
    limit = max(max(height.values()) * threshold, 16 * least, Fraction(1))
    peaks = [taxel for taxel in height if height[taxel] >= limit and _is_peak(height, taxel)]
    taken: set[Taxel] = set()
    found: list[Plain] = []
    while (rest := [taxel for taxel in peaks if taxel not in taken]) and len(found) < most:
        peak = max(rest, key=lambda taxel: (height[taxel], -taxel[0], -taxel[1]))
        high = {taxel for taxel in height if 2 * height[taxel] >= height[peak]}
        region, edge = {peak}, [peak]
        while edge:
            row, column = edge.pop()
            for near in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
                if near in high - taken - region:
                    region.add(near)
                    edge.append(near)
        touching = any(abs(r - i) + abs(c - j) == 1 for r, c in region for i, j in high & taken)
        middle = Fraction(sum(r for r, _ in region), len(region)), Fraction(sum(c for _, c in region), len(region))
        top, left = (
            floor(_sixteenths(at) - Fraction(size - 1, 2) + Fraction(1, 2))
            for at, size in zip(middle, window, strict=True)
        )
        found.append(Plain(region, middle, (top, left), touching))
        taken |= {(r, c) for r, c in height for i, j in region if max(abs(r - i), abs(c - j)) <= gap}
    return found, len([taxel for taxel in peaks if taxel not in taken])


def _is_peak(height: dict[Taxel, int], taxel: Taxel) -> bool:
    row, column = taxel
    near = {(row + i, column + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} - {taxel}
    return all(height[taxel] > height[n] if n < taxel else height[taxel] >= height[n] for n in near if n in height)


def _sixteenths(value: Fraction) -> Fraction:
    return Fraction(floor(16 * value + Fraction(1, 2)), 16)
