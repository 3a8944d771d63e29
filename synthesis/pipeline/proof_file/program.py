"""Linear programs over laws whose third derivative is constant between knots.

Their rows are those that the checker derives, made into floating point, and its own arithmetic
says what their multipliers prove. Nothing here has to be right: what is wrong proves less.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache
from itertools import product
from math import factorial, pi
from typing import Any

import numpy as np
from scipy import sparse

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.pipeline.proof_file.checker import checker
from synthesis.pipeline.proof_file.laws import ORDER, Json, Law, Row

DEGREE = pi / 180.0  # rad
DIRECTIONS = 64  # of tangents of a circle around the axis
SAMPLES = 25  # of a given law
FIGURES = 9  # of a multiplier
SMALL = 1e-9  # of the largest multiplier: what is left out
FINE = 16  # points of an interval at which ψ is looked at
LEAST = 4e-4  # of a law: width of an interval
LOOSE = 1e-7  # of a row at points of which there is also a density: it is preferred
FAR = 1e3  # lifts: where nothing else bounds a size


class Program:
    """The linear program of a question."""

    def __init__(self, question: Any, knots: dict[int, Array]) -> None:
        judge = checker()
        self.question, self.judge, self.laws = question, judge, list[Law]()
        self.unit = float(question.unit[0])  # of the first size in the checker's rows
        self.knots = knots  # of free laws, and places of others where their rows are looked at
        self.jerk, width = float(question.jerk or 0.0), 0
        free = [s for s in question.turning if s.free]
        for s in free:
            cap = self.jerk * float(s.degrees) ** ORDER / abs(float(s.lift))
            law = Law(s, width, knots[s.index], cap, [])
            width += len(law.knots) - 1
            for k in (1, 2):
                law.start.append(self._known(s.before, s, k))
                law.columns.append(width if law.start[-1] is None else -1)
                width += law.start[-1] is None
            self.laws.append(law)
        self.width = width + 2  # the size e and s0 [mm] come last
        self.by_index = {law.segment.index: law for law in self.laws}
        self.ends, self.end_values, self.end_names = self._end_conditions()
        self.fixed, self.point = list(self._linear_rows()), np.zeros(self.width)

    def _known(self, left: Any, right: Any, k: int) -> float | None:
        """g^(k) of a free law at 0 where what comes before it tells; None where it is open."""
        factor = float(right.degrees) ** k / float(right.lift)
        if not left.free:
            low, high = self.judge.given(left.law, k, Fraction(1))
            return float(low + high) / 2 * float(left.lift) / float(left.degrees) ** k * factor
        turns = left.forward and right.forward and left.lift * right.lift < 0
        return 0.0 if k == 1 and turns else None

    def _end_conditions(self) -> tuple[Array, Array, list[tuple[int, int]]]:
        rows, values, names = [], [], []
        for law in self.laws:
            left, right = law.segment, law.segment.after
            for k in range(ORDER):
                matrix, constant = law.rows(np.ones(1), k, self.width)
                value = 1.0 if k == 0 else 0.0
                factor = float(left.degrees) ** k / float(left.lift)
                if k and not right.free:
                    low, high = self.judge.given(right.law, k, Fraction(0))
                    value = float(low + high) / 2 * float(right.lift) / float(right.degrees) ** k
                    value *= factor
                elif k:
                    after = self.by_index[right.index]
                    if after.start[k - 1] is None:
                        share = float(right.lift) / float(right.degrees) ** k * factor
                        matrix[:, after.columns[k - 1]] -= share
                rows.append(matrix[0])
                values.append(value - constant[0])
                names.append((left.index, k))
        return np.array(rows).reshape(-1, self.width), np.array(values), names

    def motion(
        self, segment: Any, x: Array, order: int, factor: float = 0.0
    ) -> tuple[Array, Array]:
        """s, v or a at x, affine in the columns; with a factor, so much of a derivative of g."""
        level = float(segment.level) if order == 0 and not factor else 0.0
        factor = factor or float(segment.lift) / float(segment.degrees) ** order
        if segment.free:
            matrix, constant = self.by_index[segment.index].rows(x, order, self.width)
            return factor * matrix, factor * constant + level
        g = [given_law(segment.law, order, each) for each in x.tolist()]
        return np.zeros((len(x), self.width)), factor * np.array(g) + level

    def place(self, index: int, x: Array) -> Array:
        """s of a free law at x, of the last point."""
        matrix, constant = self.motion(self.by_index[index].segment, x, 0)
        return constant + matrix @ self.point[: self.width]

    def row(self, segment: Any, x: Array, alpha: Any, size: Any, upper: Any) -> tuple[Array, Array]:
        """Rows alpha · (g, g', g'') + size · (c e, s0) ≤ upper at x: the columns' part, rest."""
        matrix, rest = np.zeros((len(x), self.width)), np.full(len(x), float(upper))
        for k, each in enumerate(alpha[:ORDER]):
            if each:
                part, constant = self.motion(segment, x, k, 1.0)
                matrix += float(each) * part
                rest -= float(each) * constant
        matrix[:, -2] += float(size[0]) * self.unit
        matrix[:, -1] += float(size[1])
        return matrix, rest

    def points(self, segment: Any) -> Array:
        if segment.free:
            return self.by_index[segment.index].knots
        if not segment.lift:
            return np.zeros(1)
        coarse = np.round(np.linspace(0.0, 1.0, SAMPLES), 9)
        return self.knots.get(segment.index, coarse)

    def _linear_rows(self) -> Iterator[Row]:
        for name, limit in self.question.limits.items():
            for segment in self.question.turning:
                for side in (1, -1):
                    # those of windows hold at some places alone
                    if self.question.bends(limit) or limit["kind"] in ("distance", "within"):
                        continue
                    found = self.question.row(segment, limit, side)
                    found = self.judge.scaled(segment, found)
                    if found is None or (segment.free and any(found[0][ORDER:])):
                        continue
                    if not segment.free and not any(found[1]):
                        continue
                    x, jumps = self.points(segment), segment.free and found[0][2]
                    matrix, upper = self.row(segment, x, *found)
                    alpha = np.array([[float(a) for a in found[0][:ORDER]]])
                    for at, row, most in zip(x.tolist(), matrix, upper, strict=True):
                        loose = LOOSE * abs(most) * bool(jumps)
                        one = np.array([at])
                        yield Row(segment.index, name, side, at, at, row, most + loose, one, alpha)
                    if jumps:
                        yield from self._mean_rows(segment, name, side, x, found)

    def _mean_rows(self, segment: Any, name: str, side: int, x: Array, found: Any) -> Iterator[Row]:
        for a, b in zip(x[:-2].tolist(), x[2:].tolist(), strict=True):
            at = a + (b - a) * (np.arange(8) + 0.5) / 8.0
            matrix, upper = self.row(segment, at, *found)
            alpha = np.array([[float(f) for f in found[0][:ORDER]]] * 8) / 8.0
            row, most = matrix.mean(axis=0), float(upper.mean())
            yield Row(segment.index, name, side, a, b, row, most, at, alpha)

    def bend_rows(self, zones: dict[int, list[tuple[float, float]]]) -> Iterator[Row]:
        """Rows of radii: of free laws in their zones, of others all along."""
        judge, question = self.judge, self.question
        for name, limit in question.limits.items():
            if not self.question.bends(limit):
                continue
            for segment in question.turning:
                points = self.points(segment)
                if segment.free:
                    inside = [
                        (a <= points) & (points <= b) for a, b in zones.get(segment.index, ())
                    ]
                    points = points[np.any(inside, axis=0)] if inside else points[:0]
                places = [(x, x) for x in points.tolist()]
                if segment.free:
                    places += [
                        (a, b)
                        for (a, _), (b, _) in zip(places[:-2], places[2:], strict=True)
                        if any(low <= a and b <= high for low, high in zones[segment.index])
                    ]
                sides = [side for side, *_, path in question.flanks if path == 0]
                for side, (a, b) in product(sides, places):
                    if any(p is None for p in (question.heights[1], *question.offsets)):
                        continue
                    try:
                        row = self._bend_row(segment, name, limit, side, a, b)
                    except judge.Failure:
                        continue
                    yield row

    def _bend_row(self, segment: Any, name: str, limit: Json, side: int, a: float, b: float) -> Row:
        count = self.judge.SLICES if a < b else 1
        first, last = (Fraction(repr(x)) for x in (a, b))
        total, rest, alpha, places = np.zeros(self.width), 0.0, [], []
        for k in range(count):
            x = first + (last - first) * Fraction(2 * k + 1, 2 * count)
            self.judge.spent.clear()
            found = self.question.bent_row(segment, limit, x, side, None)
            matrix, upper = self.row(segment, np.array([float(x)]), *found)
            alpha.append([float(f) / count for f in found[0][:ORDER]])
            places.append(float(x))
            total, rest = total + matrix[0] / count, rest + float(upper[0]) / count
        if a == b and segment.free:
            rest += LOOSE * abs(rest)
        both = np.array(places), np.array(alpha)
        return Row(segment.index, name, side, a, b, total, rest, *both)

    def minimise(
        self, costs: Sequence[Array], rows: Sequence[Row], radius: float | None, price: float = 0.0
    ) -> list[tuple[float, Array, Array]] | None:
        """The least values of some costs (width,), and multipliers of ends and rows.

        ``radius``: largest √(e² + s0²). None: it is minimised itself, and there are no costs.
        ``price``: what elastic rows may be broken for, all by as much; 0: they may not.
        Returns None where no law and size fit.
        """
        alone = radius is None
        width = self.width + alone
        table = np.array([row.values for row in rows]).reshape(-1, self.width)
        upper = np.array([row.upper for row in rows])
        angles = np.linspace(-0.5, 0.5, DIRECTIONS + 1) * pi
        fan = np.zeros((len(angles), width))
        fan[:, self.width - 2], fan[:, self.width - 1] = np.sin(angles), np.cos(angles)
        if alone:
            fan[:, -1] = -1.0
            table, ends = _widened(table), _widened(self.ends)
            limit, costs = 0.0, [np.eye(width)[-1]]
            if price:
                loose = -np.array([[float(row.elastic)] for row in rows]).reshape(-1, 1)
                table, ends, fan = np.hstack([table, loose]), _widened(ends), _widened(fan)
                costs, width = [np.append(costs[0], price)], width + 1
        else:
            ends, limit = self.ends, float(radius or 0.0)
        scale = np.maximum(np.abs(table).max(axis=1, initial=0.0), 1e-12)
        matrix = np.concatenate([ends, table / scale[:, None], fan])
        rhs = np.concatenate([self.end_values, upper / scale, np.full(len(fan), limit)])
        low, high = np.full(width, -np.inf), np.full(width, np.inf)
        for law in self.laws:
            own = slice(law.first, law.first + len(law.knots) - 1)
            low[own], high[own] = -1.0, 1.0
        most = FAR * max(abs(float(s.lift)) for s in self.question.turning)
        if alone:
            low[self.width :] = 0.0
        for column, ends_ in (
            (self.width - 2, self.question.offsets),
            (self.width - 1, self.question.heights),
        ):
            low[column], high[column] = (
                s * most if e is None or (
                    alone and k and column == self.width - 1 and not price
                ) else float(e)
                for k, (s, e) in enumerate(zip((-1.0, 1.0), ends_, strict=True))
            )  # fmt: skip
        program = LinearRows(sparse.csc_matrix(matrix), rhs, len(ends), low, high)
        found = minimise_each(program, costs)
        if found[-1].stopped is not StopReason.SOLVED:
            return None
        self.point = found[-1].x
        answers = []
        for each, cost in zip(found, costs, strict=True):
            z = each.multipliers
            own = np.maximum(z[len(ends) : len(ends) + len(rows)], 0.0) / scale
            answers.append((float(cost @ each.x), z[: len(ends)], own))
        return answers

    def finer(self, nu: Array, z: Array, rows: Sequence[Row], least: float) -> dict[int, Array]:
        """Knots where ψ changes its sign, and in the middle of intervals that lose by it."""
        result = {}
        for law in self.laws:
            x, index = law.knots, law.segment.index
            tau = x[:-1, None] + np.diff(x)[:, None] * (np.arange(FINE) + 0.5) / FINE
            psi: Array = np.zeros(tau.size)
            at, weights = list[Array]([np.ones(1)]), list[Array]([np.zeros((1, ORDER))])
            for (owner, k), value in zip(self.end_names, nu, strict=True):
                weights[0][0, k] += value if owner == index else 0.0
            for row, value in zip(rows, z, strict=True):
                if row.segment == index and value > 0.0:
                    at.append(row.places)
                    weights.append(value * row.alpha)
            for place, each in zip(np.concatenate(at), np.concatenate(weights), strict=True):
                ahead = np.maximum(place - tau.ravel(), 0.0)
                for k in range(ORDER):
                    n = ORDER - 1 - k
                    psi += each[k] * (ahead**n / factorial(n) if n else 1.0 * (ahead > 0.0))
            psi = psi.reshape(tau.shape)
            lost = law.cap * np.diff(x) * (np.abs(psi).mean(axis=1) - np.abs(psi.mean(axis=1)))
            new = list(x)
            for i in np.flatnonzero(lost > least):
                change = np.flatnonzero(psi[i, 1:] * psi[i, :-1] < 0.0)
                new += [0.5 * (x[i] + x[i + 1])]
                if 0 < len(change) < 3:
                    for j in change:
                        a, b = psi[i, j], psi[i, j + 1]
                        new.append(tau[i, j] + (tau[i, j + 1] - tau[i, j]) * a / (a - b))
            result[index] = thinned(np.array(new), LEAST)
        return result

    def stated(self, nu: Array, z: Array, rows: Sequence[Row]) -> Json:
        """Multipliers as the file has them."""
        parts: dict[int, dict[tuple[str, int], list[list[float]]]] = {}
        ends: dict[int, list[float]] = {}
        for law in self.laws:
            parts[law.segment.index] = {}
            ends[law.segment.index] = []
        for (index, _), value in zip(self.end_names, nu.tolist(), strict=True):
            ends[index].append(_short(value))
        most = float(z.max(initial=0.0))
        for row, value in zip(rows, z.tolist(), strict=True):
            if value <= SMALL * most:
                continue
            group = parts.setdefault(row.segment, {}).setdefault((row.limit, row.side), [])
            height = _short(value / (row.y - row.x or 1.0))
            if row.touch is not None:
                group.append([row.x, height, row.touch])
                continue
            group.append([row.x, height] if row.x == row.y else [row.x, row.y, height, height])
        return {
            "order": ORDER,
            "segments": [
                {
                    "segment": index,
                    "rows": [
                        {"limit": name, "side": side, "multipliers": values}
                        for (name, side), values in groups.items()
                    ],
                    "ends": ends.get(index, []),
                }
                for index, groups in sorted(parts.items())
            ],
        }


@cache
def given_law(law: str, order: int, x: float) -> float:
    """A derivative of a named law at a place."""
    place = Fraction(x).limit_denominator(10**9)
    return float(sum(map(float, checker().given(law, order, place)))) / 2.0


def _widened(table: Array) -> Array:
    return np.column_stack([table, np.zeros(len(table))])


def _short(value: float) -> float:
    return float(f"{value:.{FIGURES}g}")


def thinned(x: Array, least: float) -> Array:
    """Places on a law from 0 to 1, none nearer to another than a least distance."""
    kept = [0.0]
    for each in np.round(np.unique(x), 9).tolist():
        if each - kept[-1] >= least and 1.0 - each >= least:
            kept.append(each)
    return np.array([*kept, 1.0])
