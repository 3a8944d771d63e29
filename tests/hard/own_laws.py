"""Every named law again, from its published acceleration or powers, and splines by SciPy.

Nothing of the product is imported here. A law is a list of pieces (x0, x1, g) on [0, 1], with
g(x, n) the n-th derivative of the normalised displacement on that closed piece: one-sided values
at both ends come by themselves.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, factorial, pi, sin
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import BSpline, PPoly

Curve = Callable[[np.ndarray, int], np.ndarray]
Piece = tuple[float, float, Curve]

SCCA = {
    "parabolic": (0, 1, 0), "simple_harmonic": (0, 0, 1), "cycloidal": (0.5, 0, 0.5),
    "modified_trapezoid": (0.25, 0.5, 0.25), "modified_sine": (0.25, 0, 0.75),
    "mcv50_makino": (0.125, 0, 0.375), "cv50_half_sine": (0.25, 0, 0.25),
    "cv50_modified_trapezoid": (0.125, 0.25, 0.125), "scca_cv20": (0.2, 0.4, 0.2),
}  # fmt: skip
POWERS = {
    "cubic_2_3": (2, (3, -2)),
    "polynomial_3_4_5": (3, (10, -15, 6)),
    "polynomial_4_5_6_7": (4, (35, -84, 70, -20)),
    "polynomial_5_6_7_8_9": (5, (126, -420, 540, -315, 70)),
    "polynomial_6_7_8_9_10_11": (6, (462, -1980, 3465, -3080, 1386, -252)),
    "peisakh_11": (5, (336, -1890, 4740, -6615, 5320, -2310, 420)),
}
FIVE = 1125 / 1192
HARMONICS = {
    "gutman_1_3": {1: 15 / 16, 3: 1 / 48},
    "freudenstein_1_3": {1: 27 / 28, 3: 1 / 84},
    "freudenstein_1_3_5": {1: FIVE, 3: FIVE / 54, 5: FIVE / 1250},
}
DWELL_TURN = {
    "polynomial_3_4_5_6": (3, (8, -12, 6, -1)),
    "kloomok_muffley_8": (3, (6.09755, 0, -20.78040, 26.73155, -13.60965, 2.56095)),
}


def wave(x: np.ndarray, n: int, amplitude: float, w: float, phase: float) -> np.ndarray:
    """n-th derivative of amplitude · sin(wx + phase)."""
    return amplitude * w**n * np.sin(w * x + phase + n * pi / 2.0)


def powers(first: int, coefficients: tuple[float, ...]) -> list[Piece]:
    whole = Polynomial([0.0] * first + [float(c) for c in coefficients])
    return [(0.0, 1.0, lambda x, n: whole.deriv(n)(x) if n else whole(x))]


def integrated(parts: list[tuple[float, float, float, float, float]]) -> list[Piece]:
    """Half a law from parts (width, B, A, w, phase) of g'' = B + A sin(w(x − x0) + phase).

    Integrated twice from rest, scaled to g(1/2) = 1/2.
    """
    raw: list[tuple[float, float, Curve]] = []
    x0 = s0 = v0 = 0.0
    for width, B, A, w, phase in parts:
        if width <= 0.0:
            continue
        # g = s0 + v0 t + B t²/2 − A/w² sin(wt + φ) + A/w² sin φ + (A/w) t cos φ, t = x − x0
        more = A / w if w else 0.0

        def g(x, n, x0=x0, s0=s0, v0=v0, B=B, A=A, w=w, phase=phase, more=more):
            t = np.asarray(x, dtype=float) - x0
            rate = v0 + more * cos(phase)
            held = more / w * sin(phase) if w else 0.0
            poly = [s0 + held + rate * t + B * t * t / 2.0, rate + B * t, B + 0.0 * t]
            found = poly[n] if n < 3 else 0.0 * t
            return found - wave(t, n, more / w, w, phase) if w else found

        raw.append((x0, x0 + width, g))
        end = np.array([x0 + width])
        s0, v0, x0 = float(g(end, 0)[0]), float(g(end, 1)[0]), x0 + width
    scale = 0.5 / s0
    return [(a, b, lambda x, n, g=g: scale * g(x, n)) for a, b, g in raw]


def half(kind: str, law: dict[str, Any]) -> list[Piece]:
    """First half, on [0, 1/2], of a law between two rests."""
    if kind in SCCA or kind == "scca":
        b, c, d = SCCA.get(kind) or (law.get("b", 0.25), law.get("c", 0.5), law.get("d", 0.25))
        if b + c + d > 1.0 - 1e-6:
            b, c, d = (part / (b + c + d) for part in (b, c, d))
        rest = max(0.5 - (b + c + d) / 2.0, 0.0)
        return integrated(
            [
                (b / 2, 0.0, 1.0, pi / b if b else 0.0, 0.0),
                (c / 2, 1.0, 0.0, 0.0, 0.0),
                (d / 2, 0.0, 1.0, pi / d if d else 0.0, pi / 2),
                (rest if rest > 1e-6 else 0.0, 0.0, 0.0, 0.0, 0.0),
            ]
        )
    if kind == "constant_velocity":
        return [(0.0, 0.5, lambda x, n: [x, 1.0 + 0.0 * x, 0.0 * x][min(n, 2)])]
    if kind == "cv50_haversine":
        sixteen = 16.0 / 3.0
        return integrated(
            [(0.25, sixteen, -sixteen, 8.0 * pi, pi / 2.0), (0.25, 0.0, 0.0, 0.0, 0.0)]
        )
    if kind == "cv50_parabolic":
        # g'' = 32 (4x)(1 − 4x)
        start = Polynomial([0.0, 128.0, -512.0]).integ(2)
        last = Polynomial([0.5 - 4 / 6, 4 / 3])
        return [
            (0.0, 0.25, lambda x, n: start.deriv(n)(x) if n else start(x)),
            (0.25, 0.5, lambda x, n: (last.deriv(n)(x) if n else last(x)) + 0.0 * x),
        ]
    if kind in HARMONICS:

        def series(x, n, parts=HARMONICS[kind]):
            line = [x, 1.0 + 0.0 * x, 0.0 * x][min(n, 2)]
            return line - sum(
                wave(x, n, m / (2.0 * pi), 2.0 * pi * k, 0.0) for k, m in parts.items()
            )

        return [(0.0, 0.5, series)]
    ((_, _, g),) = powers(*POWERS[kind])
    return [(0.0, 0.5, g)]


def backwards(pieces: list[Piece], end: float = 1.0) -> list[Piece]:
    """1 − f(1 − x) of pieces on [0, end], scaled lengths kept: on [1 − end, 1]."""

    def turned(g: Curve) -> Curve:
        return lambda x, n: (1.0 if n == 0 else 0.0) - (-1.0) ** n * g(1.0 - x, n)

    return [(1.0 - b, 1.0 - a, turned(g)) for a, b, g in reversed(pieces)]


def stretched(pieces: list[Piece], factor: float) -> list[Piece]:
    """factor · f(x / factor)."""
    return [
        (a * factor, b * factor, lambda x, n, g=g: factor ** (1 - n) * g(x / factor, n))
        for a, b, g in pieces
    ]


def named(law: dict[str, Any], kind: str) -> list[Piece]:
    """A named law as run from start to end of a rise or return."""
    name = law["kind"]
    if name in DWELL_TURN or name == "double_harmonic":
        if name == "double_harmonic":

            def g(x, n):
                constant = 0.375 + 0.0 * x if n == 0 else 0.0 * x
                quarter = pi / 2.0
                return constant - wave(x, n, 0.5, pi, quarter) + wave(x, n, 0.125, 2 * pi, quarter)

            pieces: list[Piece] = [(0.0, 1.0, g)]
        else:
            pieces = powers(*DWELL_TURN[name])
        towards = (kind == "rise") == (law.get("turn", "top") == "top")
        return pieces if towards else backwards(pieces)
    first = half(name, law)
    lam = law.get("inflection", 0.5)
    return stretched(first, 2.0 * lam) + backwards(stretched(first, 2.0 * (1.0 - lam)))


def spline(curve: dict[str, Any]) -> list[Piece]:
    """A B-spline from the wire: clamped ends, knots each once."""
    p, x = curve["degree"], np.array(curve["knots"])
    knots = np.concatenate([np.full(p, x[0]), x, np.full(p, x[-1])])
    whole = PPoly.from_spline(BSpline(knots, np.array(curve["coefficients"]), p))
    whole = PPoly(whole.c[:, p : len(whole.x) - 1 - p], whole.x[p : len(whole.x) - p])

    def local(i: int) -> Curve:
        powers = whole.c[::-1, i]

        def g(at: np.ndarray, n: int) -> np.ndarray:
            t = np.asarray(at, dtype=float) - whole.x[i]
            found = np.zeros_like(t)
            for k in range(len(powers) - 1, n - 1, -1):
                found = found * t + powers[k] * factorial(k) / factorial(k - n)
            return found

        return g

    return [(whole.x[i], whole.x[i + 1], local(i)) for i in range(len(whole.x) - 1)]


def hermite(left: tuple[float, ...], right: tuple[float, ...]) -> list[Piece]:
    """The quintic with g, g', g'' given at both ends."""
    rows = []
    for x in (0.0, 1.0):
        for n in range(3):
            rows.append(
                [factorial(k) / factorial(k - n) * x ** (k - n) if k >= n else 0 for k in range(6)]
            )
    return powers(0, tuple(np.linalg.solve(np.array(rows), np.array([*left, *right]))))
