"""Motions that are linear in unknowns: on every free law the jerk is constant in turns.

On a law of angle β and lift h, g(x) = p x + q x²/2 + Σ r_j K(x − x_j), where K is the triple
integral of a step. Laws of class C1 have steps of the acceleration, K the double integral. A C2 law
is approached by smoother ones as closely as one likes, so any room in the limits makes up for the
difference: a bound over all laws smoother than C2 holds for C2 laws too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import factorial, pi
from typing import Any

import numpy as np
from scipy.linalg import expm

from tests.hard.own_cam import LINE, RAD, PlacedSegment, segments, unit_of
from tests.hard.own_laws import Piece

NAMED_POINTS = 160  # samples of a law that is given
NARROWEST = 2e-3  # of a law: no piece is divided further
SHORT_PIECES = 300  # of a polynomial or a wave of a given law


@dataclass(frozen=True)
class Law:
    """Unknowns of one free law: slope and curvature at its start, then one number a piece."""

    place: PlacedSegment
    first: int  # of its unknowns
    breaks: np.ndarray
    order: int  # of the derivative that is constant on pieces: 3, or 2 of class C1

    @property
    def count(self) -> int:
        return self.order - 1 + len(self.breaks) - 1

    def rows(self, x: np.ndarray, n: int) -> np.ndarray:
        """n-th derivative of g at x, one column an unknown; at a break, of the piece behind it."""
        columns = np.stack([_power(x, k, n) for k in range(1, self.order)], axis=1)
        steps = _step(x[:, None] - self.breaks[None, :], self.order, n)
        return np.hstack([columns, steps[:, :-1] - steps[:, 1:]])

    def pieces(self, unknowns: np.ndarray) -> list[Piece]:
        """The law as polynomials, for the verifier."""
        own = unknowns[self.first : self.first + self.count]
        states = [self.rows(self.breaks[:-1], n) @ own for n in range(self.order)]
        taylor = np.stack([*states, own[self.order - 1 :]], axis=1)
        pairs = zip(pairwise(self.breaks), taylor, strict=True)
        return [(float(a), float(b), _polynomial(list(row), float(a))) for (a, b), row in pairs]


def _power(x: np.ndarray, k: int, n: int) -> np.ndarray:
    """n-th derivative of x^k / k!."""
    return np.zeros_like(x) if n > k else x ** (k - n) / factorial(k - n)


def _step(t: np.ndarray, order: int, n: int) -> np.ndarray:
    """n-th derivative of t^order / order! for t ≥ 0, else 0."""
    if n > order:
        return np.zeros_like(t)
    return np.where(t >= 0.0, np.maximum(t, 0.0) ** (order - n) / factorial(order - n), 0.0)


def _polynomial(taylor: list[float], at: float) -> Any:
    def g(x: np.ndarray, n: int) -> np.ndarray:
        t = np.asarray(x, dtype=float) - at
        parts = [taylor[k] * t ** (k - n) / factorial(k - n) for k in range(n, len(taylor))]
        return sum(parts, np.zeros_like(t))

    return g


@dataclass(frozen=True)
class Samples:
    """Displacement and derivatives per radian at samples, each affine in the unknowns.

    ``matrices[n] @ unknowns + constants[n]``; of an arm in rad.
    """

    theta: np.ndarray
    kind: np.ndarray  # "rise", "return", "dwell" of each sample
    matrices: tuple[np.ndarray, ...]
    constants: tuple[np.ndarray, ...]
    sense: np.ndarray  # ±1 where the follower must not run backwards, else 0
    inside: np.ndarray  # 1 in the middle of a segment, 0 at its ends, where laws may rest

    def at(self, unknowns: np.ndarray) -> list[np.ndarray]:
        pairs = zip(self.matrices, self.constants, strict=True)
        return [matrix @ unknowns + constant for matrix, constant in pairs]


Breaks = Callable[[int], np.ndarray]


class Program:
    """A program whose numbers are all given, its free laws of pieces.

    Args:
        spec: the question. breaks: from 0 to 1 where the pieces of a law meet, by the law's place.
    """

    def __init__(self, spec: dict[str, Any], breaks: Breaks) -> None:
        self.spec = spec
        self.unit = RAD if unit_of(spec) == "deg" else 1.0
        self.free = {
            i
            for i, segment in enumerate(spec["program"])
            if segment["kind"] in ("rise", "return")
            and (segment.get("law") or {"kind": "spline"})["kind"] == "spline"
        }
        self.places = segments(spec, dict.fromkeys(self.free, LINE))
        self.laws: dict[int, Law] = {}
        self.count = 0
        for place in self.places:
            if place.index in self.free:
                order = 2 if self._smoothness(place.index) == 1 else 3
                law = Law(place, self.count, breaks(place.index), order)
                self.laws[place.index] = law
                self.count += law.count

    def _smoothness(self, index: int) -> int:
        law = self.spec["program"][index].get("law") or {}
        return int(max(law.get("smoothness", 2), self.spec.get("continuity") or 0))

    def joined(self) -> tuple[np.ndarray, np.ndarray]:
        """Equations of the unknowns: every law ends at 1, and neighbours join."""
        rows: list[np.ndarray] = []
        values: list[float] = []
        for law in self.laws.values():
            row = np.zeros(self.count)
            row[law.first : law.first + law.count] = law.rows(np.ones(1), 0)[0]
            rows.append(row)
            values.append(1.0)
        turn = [*self.places, self.places[0]]
        for left, right in pairwise(turn):
            if not {left.index, right.index} & self.free:
                continue
            sides = [p.index for p in (left, right) if p.index in self.free]
            least = max(self._smoothness(i) for i in sides)
            for n in range(1, min(least, 2) + 1):
                end, known = self._end(left, 1.0, n)
                start, other = self._end(right, 0.0, n)
                scale = abs(left.lift or right.lift) / min(left.beta, right.beta) ** n
                rows.append((end - start) / scale)
                values.append((other - known) / scale)
        return np.array(rows).reshape(len(rows), self.count), np.array(values)

    def _end(self, place: PlacedSegment, x: float, n: int) -> tuple[np.ndarray, float]:
        """n-th derivative at an end of a segment: a row of the unknowns, and a constant."""
        row = np.zeros(self.count)
        if place.index in self.free:
            law = self.laws[place.index]
            own = law.rows(np.array([x]), n)[0] * place.lift / place.beta**n
            row[law.first : law.first + law.count] = own
            return row, 0.0
        piece = len(place.pieces) - 1 if x == 1.0 else 0
        return row, float(place.at(piece, np.array([x]), n)[0])

    def samples(self, each: int) -> Samples:
        """``each`` samples on a piece, both ends included: the jerk has two values at a break."""
        theta, kinds, sense, middles = [], [], [], []
        matrices: list[list[np.ndarray]] = [[] for _ in range(4)]
        constants: list[list[np.ndarray]] = [[] for _ in range(4)]
        for place in self.places:
            law = self.laws.get(place.index)
            at = np.linspace(0.0, 1.0, 2 if place.kind == "dwell" else NAMED_POINTS)
            inner = at
            if law is not None:
                shares = np.linspace(0.0, 1.0, each)
                both = law.breaks[:-1, None] + np.diff(law.breaks)[:, None] * shares
                at = both.ravel()
                # derivatives at the end of a piece are those before it
                inner = (both - 1e-12 * (shares == 1.0)).ravel()
            theta.append(place.start + place.beta * at)
            kinds += [place.kind] * len(at)
            one_way = law is not None and not (place.free or {}).get("overshoot", False)
            sense += [np.sign(place.lift) if one_way else 0.0] * len(at)
            middles.append((4.0 * at * (1.0 - at)) ** 2)
            for n in range(4):
                block = np.zeros((len(at), self.count))
                level = np.full(len(at), place.level if n == 0 else 0.0)
                if law is not None:
                    own = law.rows(inner, n) * place.lift / place.beta**n
                    block[:, law.first : law.first + law.count] = own
                else:
                    level = level + self._given(place, at, n)
                matrices[n].append(block * self.unit)
                constants[n].append(level * self.unit)
        return Samples(
            np.concatenate(theta), np.array(kinds),
            tuple(np.concatenate(m) for m in matrices),
            tuple(np.concatenate(c) for c in constants), np.array(sense),
            np.concatenate(middles),
        )  # fmt: skip

    def ringing(self, frequency: float, damping: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """Amplitude that every run between two dwells leaves an oscillator.

        Its equation is q'' + 2ζν q' + ν²q = −s''.

        Args:
            frequency: ν, swings of the undamped oscillator in a turn. damping: ζ.

        Returns:
            for each run a matrix (2, unknowns) and constants (2,): the amplitude, in the unit of
            the lifts, is the length of ``matrix @ unknowns + constants``. On a piece s'' is linear,
            so that the matrix exponential is exact there; of given laws pieces are short.
        """
        damped = frequency * (1.0 - damping**2) ** 0.5
        rates = np.zeros((4, 4))  # of q, its speed, the acceleration of the cam, and its jerk
        rates[0, 1] = rates[2, 3] = 1.0
        rates[1, :3] = -(frequency**2), -2.0 * damping * frequency, -1.0
        ends = np.array([[1.0, 0.0], [damping * frequency / damped, 1.0 / damped]])
        found = []
        for run in _runs(self.places):
            state, before = np.zeros((2, self.count + 1)), np.zeros(self.count + 1)
            for place in run:
                state[1] -= np.append(*self._end(place, 0.0, 1)) - before  # a step of the speed
                before = np.append(*self._end(place, 1.0, 1))
                for width, bends in self._bends(place):
                    ahead = expm(rates * width)[:2]
                    state = ahead[:, :2] @ state + ahead[:, 2:] @ bends
            state[1] += before
            amplitude = ends @ state
            found.append((amplitude[:, :-1], amplitude[:, -1]))
        return found

    def _bends(self, place: PlacedSegment) -> Iterator[tuple[float, np.ndarray]]:
        """Widths of a segment's pieces; acceleration and jerk at starts: (2, unknowns + 1)."""
        law = self.laws.get(place.index)
        if law is not None:
            for a, b in pairwise(law.breaks):
                bends = np.zeros((2, self.count + 1))
                for k, n in enumerate((2, 3)):
                    own = law.rows(np.array([a]), n)[0] * place.lift / place.beta**n
                    bends[k, law.first : law.first + law.count] = own
                yield place.beta * (b - a), bends
            return
        for piece, (a, b, _) in enumerate(place.pieces):
            second = place.at(piece, np.linspace(a, b, SHORT_PIECES + 1), 2)
            width = place.beta * (b - a) / SHORT_PIECES
            for here, there in pairwise(second):
                bends = np.zeros((2, self.count + 1))
                bends[:, -1] = here, (there - here) / width
                yield width, bends

    def _given(self, place: PlacedSegment, x: np.ndarray, n: int) -> np.ndarray:
        found = np.zeros_like(x)
        for a, b, g in place.pieces:
            inside = (x >= a) & (x <= b)
            found[inside] = place.lift / place.beta**n * g(x[inside], n)
        return found

    def divided(self, unknowns: np.ndarray) -> tuple[Program, np.ndarray]:
        """The same motion on other pieces: equal neighbours are one, those amid jumps are divided.

        The jerk of an optimum jumps between its bounds; where it lies between them, a jump lies
        inside the piece, or the jerk is a curve there.
        """
        found: dict[int, np.ndarray] = {}
        for index, law in self.laws.items():
            heights = unknowns[law.first + law.order - 1 : law.first + law.count]
            most = max(float(np.max(np.abs(heights))), 1e-300)
            jumps = np.abs(np.diff(heights)) > 1e-4 * most
            kept = [0.0, *law.breaks[1:-1][jumps], 1.0]
            inner = np.abs(heights) < (1.0 - 1e-4) * most
            middles = [
                a + (b - a) * share
                for a, b, inside in zip(law.breaks, law.breaks[1:], inner, strict=False)
                for share in (0.35, 0.65)
                if inside and b - a > NARROWEST
            ]
            halves = [0.5 * (a + b) for a, b in pairwise(kept) if b - a > 0.25]
            found[index] = np.array(sorted({*kept, *middles, *halves}))
        other = Program(self.spec, found.__getitem__)
        moved = np.zeros(other.count)
        for index, law in other.laws.items():
            old = self.laws[index]
            own = unknowns[old.first : old.first + old.count]
            moved[law.first : law.first + law.order - 1] = own[: old.order - 1]
            middle = 0.5 * (law.breaks[1:] + law.breaks[:-1])
            heights = old.rows(middle, old.order) @ own
            moved[law.first + law.order - 1 : law.first + law.count] = heights
        return other, moved

    def placed(self, unknowns: np.ndarray) -> list[PlacedSegment]:
        """The motion for the verifier."""
        return segments(self.spec, {i: law.pieces(unknowns) for i, law in self.laws.items()})

    @property
    def stroke(self) -> float:
        """Highest less lowest level, of an arm in rad."""
        levels = [p.level + lift for p in self.places for lift in (0.0, p.lift)]
        return (max(levels) - min(levels)) * self.unit

    @property
    def omega(self) -> float:
        return float(self.spec.get("speed_rpm", 60.0)) * pi / 30.0


def _runs(places: list[PlacedSegment]) -> Iterator[list[PlacedSegment]]:
    """The moves between two dwells, each run from one dwell on; none where nothing rests."""
    rests = [k for k, place in enumerate(places) if place.kind == "dwell"]
    for here, there in pairwise([*rests, *(k + len(places) for k in rests[:1])]):
        if there > here + 1:
            yield [places[k % len(places)] for k in range(here + 1, there)]
