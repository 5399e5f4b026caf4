"""Numbers as text: significant digits, thousands separators, a dash where there is none."""

from collections.abc import Sequence

DASH = "–"

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 3) -> str:
    """``value`` with so many significant ``digits`` and thousands separators: 1234.5 is 1,230.

    Below 1e-4 it has a power of ten.
    """
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    rounded, magnitude = float(f"{mantissa}e{exponent}") + 0.0, int(exponent)
    if rounded and magnitude < -4:
        return f"{mantissa}×10{str(magnitude).translate(_SUPERSCRIPT)}"
    return f"{rounded:,.{max(0, digits - 1 - magnitude) if rounded else 0}f}"


def cell(value: object) -> str:
    """The text of a table's cell: text as it is, whole numbers in full, others with six digits, a dash for None."""
    match value:
        case None:
            return DASH
        case bool():
            return "yes" if value else "no"
        case int():
            return f"{value:,}"
        case float():
            return f"{value:,.6g}"
    return str(value)


def listed(words: Sequence[str]) -> str:
    """Words as in a sentence: ``a, b and c``."""
    *first, last = words or ("",)
    return f"{', '.join(first)} and {last}" if first else last
