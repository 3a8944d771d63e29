"""π, sine and cosine to forty digits, from the standard library's decimals alone.

The reference values of the tests are computed with these, so that no error of the reference can
hide one of the product: the Taylor series is summed until it no longer changes.
"""

from decimal import Decimal, getcontext

getcontext().prec = 50


def _pi() -> Decimal:
    # Machin 1706: π = 16 atan(1/5) − 4 atan(1/239)
    def atan_of_inverse(n: int) -> Decimal:
        total, power, k = Decimal(0), Decimal(1) / n, 0
        while total + power / (2 * k + 1) != total:
            total += (-1) ** k * power / (2 * k + 1)
            power /= n * n
            k += 1
        return total

    return 16 * atan_of_inverse(5) - 4 * atan_of_inverse(239)


PI = _pi()


def _series(x: Decimal, first: int) -> Decimal:
    """Σ (−1)^k x^(2k+first)/(2k+first)!, the cosine's for first = 0, the sine's for 1."""
    term = x if first else Decimal(1)
    total, n = term, first
    while True:
        term *= -x * x / ((n + 1) * (n + 2))
        n += 2
        if total + term == total:
            return total
        total += term


def sin(x: Decimal) -> Decimal:
    return _series(x.remainder_near(2 * PI), 1)


def cos(x: Decimal) -> Decimal:
    return _series(x.remainder_near(2 * PI), 0)
