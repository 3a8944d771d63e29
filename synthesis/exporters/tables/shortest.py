"""Numbers as the shortest decimal text that reads back to the same double, whole columns at once.

The text is Python's ``repr``, which takes half a microsecond a number and so would take longer than
everything else in a file. Here 17 digits are found exactly: for 1e-4 ≤ |x| < 1e16 the power of ten
that makes x a number of 17 digits is itself a double, and the product of two doubles is a sum of
two doubles (Dekker 1971). Fewer digits do if they stay within half the spacing of doubles at x.
(Below a power of two doubles stand twice as close; a test goes through all of them in the range.)
What lies outside of that range is rare in a table and left to ``repr``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array

Cells = NDArray[np.uint8]
Whole = NDArray[np.int64]

LEAST, MOST = 1e-4, 1e15  # between these, texts are written in full and found here
FILL = 7  # zeros before the first of the 17 digits, enough for 0.0001
PLACES = np.arange(FILL + 17)
WIDTH = 1 + len(PLACES) + 1  # sign, digits, point
SPLITTER = 2.0**27 + 1.0
TENS = np.array([float(10**k) for k in range(23)])  # exact
ZERO, POINT, MINUS = 48, 46, 45
# The four digits of 0 to 9999, as one word each.
DIGITS = np.arange(10000)[:, None] // np.array([1000, 100, 10, 1]) % 10 + ZERO
FOUR = DIGITS.astype(np.uint8).view(np.uint32)[:, 0]


def to_text(values: Array | Whole, infinite: str = "inf") -> Cells:
    """Texts in ASCII, (n, WIDTH); a zero byte is no character, wherever it stands.

    Args:
        values: (n,) numbers; of whole numbers no digit is lost either.
        infinite: what to write for +∞ (−∞ is not expected).
    """
    if values.dtype.kind == "i":
        return _bytes(values.astype(f"S{WIDTH}"))
    magnitude = np.abs(values)
    usual = (magnitude >= LEAST) & (magnitude < MOST)
    cells = np.zeros((len(values), WIDTH), dtype=np.uint8)
    cells[usual] = _usual(np.asarray(values[usual], dtype=float))
    cells[values == 0.0, :3] = ZERO, POINT, ZERO
    rest = np.flatnonzero(~usual & (values != 0.0))
    if len(rest):
        texts = [repr(value).replace("inf", infinite) for value in values[rest].tolist()]
        cells[rest] = _bytes(np.array(texts, dtype=f"S{WIDTH}"))
    return cells


def join_cells(cells: Cells) -> bytes:
    """All characters, row by row."""
    return cells.tobytes().translate(None, b"\0")


def _bytes(texts: NDArray[np.bytes_]) -> Cells:
    return np.frombuffer(texts.tobytes(), dtype=np.uint8).reshape(len(texts), WIDTH)


def _usual(values: Array) -> Cells:
    number, exponent = _digits(np.abs(values))
    units = FILL + exponent  # place of the digit before the point
    first = np.minimum(units, FILL)
    last = np.maximum(FILL + 16 - _end_zeros(number), units + 1)
    seen = (first[:, None] <= PLACES) & (last[:, None] >= PLACES)
    digits = _characters(number) * seen
    cells = np.zeros((len(values), WIDTH), dtype=np.uint8)
    cells[:, 2:] = digits  # as they stand behind the point, and then before it
    np.copyto(cells[:, 1:-1], digits, where=units[:, None] >= PLACES)
    cells[np.arange(len(values)), units + 2] = POINT
    cells[:, 0] = (values < 0.0) * np.uint8(MINUS)
    return cells


def _digits(x: Array) -> tuple[Whole, Whole]:
    """Shortest digits of x > 0, filled with zeros to a number of 17; and floor(log10 x)."""
    exponent = np.floor(np.log10(x)).astype(np.int64)
    high = x * TENS[16 - exponent]
    exponent += (high >= 1e17).astype(np.int64) - (high < 1e16).astype(np.int64)
    power = TENS[16 - exponent]
    high, low = _product(x, power)
    near = np.rint(low)
    number = high.astype(np.int64) + near.astype(np.int64)
    rest = low - near
    room = 0.5 * np.spacing(x) * power
    best = number
    for scale in (10, 100):
        quotient = number // scale
        over = (number - quotient * scale) + rest
        up = (over > 0.5 * scale) | ((over == 0.5 * scale) & (quotient % 2 == 1))
        fits = np.abs(over - scale * up) < room
        best = np.where(fits, (quotient + up) * scale, best)
    return best, exponent


def _product(a: Array, b: Array) -> tuple[Array, Array]:
    """a b as a sum of two doubles, exactly (Dekker)."""
    a_high, b_high = _upper(a), _upper(b)
    a_low, b_low = a - a_high, b - b_high
    high = a * b
    return high, ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low


def _upper(a: Array) -> Array:
    """The upper half of a double's digits."""
    scaled = SPLITTER * a
    return scaled - (scaled - a)


def _end_zeros(number: Whole) -> Whole:
    """How many zeros each number ends with."""
    count = np.zeros_like(number)
    rows, rest = np.arange(len(number)), number
    while len(rows):
        ends = rest % 10 == 0
        rows, rest = rows[ends], rest[ends] // 10
        count[rows] += 1
    return count


def _characters(number: Whole) -> Cells:
    """The 17 digits of each number in ASCII behind FILL zeros: (n, FILL + 17)."""
    words = np.empty((len(number), 6), dtype=np.uint32)
    words[:, 0] = FOUR[0]
    high = number // 10**8
    low = (number - high * 10**8).astype(np.uint32)
    top = (high // 10**8).astype(np.uint32)
    middle = (high - top * np.int64(10**8)).astype(np.uint32)
    words[:, 1] = FOUR[top]
    for k, eight in ((2, middle), (4, low)):
        upper = eight // np.uint32(10000)
        words[:, k] = FOUR[upper]
        words[:, k + 1] = FOUR[eight - upper * np.uint32(10000)]
    return words.view(np.uint8)
