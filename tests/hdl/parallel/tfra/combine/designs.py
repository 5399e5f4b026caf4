"""Small designs of every kind: words a cycle, and vectors longer and shorter than multiplier operands."""

from tests.hdl.parallel.designs import make
from tfra.model.choices import Formats

DESIGNS = [
    make(4, 4),
    make(3, 5, "wide"),
    make(2, 2),
    make(4, 6, Formats("long vectors", 12, 10, 16, 4), bits=10),
    make(3, 2, Formats("short vectors", 12, 27, 0, 0), bits=6),
    make(3, 4, words=2),
    make(2, 2, words=1),
    make(5, 4, words=1),
]


def beats(design, quads):
    """The words of ``quads (n, 4)`` beat by beat."""
    size = design.architecture.vector_words
    return [[int(word) for word in quad[first : first + size]] for quad in quads for first in range(0, 4, size)]


def transfers(design, rng, port, quads):
    """Cycles in which ``quads`` come at a port that is always ready: at random, payloads stand for a quad's beats."""
    for quad in quads:
        for cycle in range(design.cycles_per_quad + rng.randrange(3)):
            yield {f"{port}.payload": [int(word) for word in quad], f"{port}.valid": int(cycle == 0)}


def words(rng, bits, number):
    """Signed words of ``bits`` and less; every length is as likely, ends of the range among them."""
    lengths = (rng.randrange(bits) for _ in range(number))
    return [rng.choice([rng.randrange(-1 << n, 1 << n), -1 << n, (1 << n) - 1]) for n in lengths]
