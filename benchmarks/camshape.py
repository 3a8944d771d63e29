"""Public benchmark camshape (COPS, CUTEst, MINLPLib): the global optimum and its proof."""

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import timed

ALPHA = 1.5
LEAST, LARGEST = 1.0, 2.0
SIZES = (100, 200, 400, 800, 1600)
PUBLISHED = {100: 4.284147122, 200: 4.278500233}  # proven optima
EPS = float(np.finfo(float).eps)
TEXT = """The public benchmark of COPS, CUTEst and MINLPLib: the greatest feasible radii, in closed
form ([why they are the optimum](../reference/camshape.md)), and a bound from the constraints
alone."""


def step(n: int) -> float:
    """θ: the cam's angle between two radii [rad]."""
    return 2.0 * math.pi / (5 * (n + 1))


def value(r: np.ndarray) -> float:
    """The objective (π/n) Σ r_i, i = 1..n, of the radii r_{-1} .. r_{n+2}."""
    inner = r[2:-2]
    return math.pi / len(inner) * math.fsum(inner)


def shape(n: int) -> np.ndarray:
    """The greatest feasible radii r_{-1}, r_0, ..., r_{n+2}: (n+4,).

    Straight line as long as its radius grows slowly enough, then as fast as it may, then the
    largest radius. See docs/reference/camshape.md for why no feasible radius is larger.
    """
    theta = step(n)
    i = np.arange(-1, n + 3)
    line = math.cos(theta / 2.0) / np.cos((i + 0.5) * theta)  # 1/r from r_{-1} = r_0 = 1
    steep = np.diff(line) > ALPHA * theta
    last = int(np.argmax(steep)) if steep.any() else n + 3
    spiral = line[last] + ALPHA * theta * (i - i[last])
    return np.minimum(np.where(i <= i[last], line, spiral), LARGEST)


def breach(r: np.ndarray) -> float:
    """By how much the worst constraint is broken, each as stated in r; 0 or less: none is."""
    n = len(r) - 4
    theta = step(n)
    before, at, after = r[:-2], r[1:-1], r[2:]
    worst = [
        2.0 * before * after * math.cos(theta) - at * (before + after),
        abs(np.diff(r[1:-1])) - ALPHA * theta,
        LEAST - r,
        r - LARGEST,
        abs(r[:2] - LEAST),
        abs(r[-2:] - LARGEST),
    ]
    return max(float(np.max(part)) for part in worst)


@dataclass(frozen=True)
class Proof:
    """An upper bound of every radius, from the constraints alone.

    Attributes:
        radii: no feasible r_i, i = 1..n, is larger: (n,).
        value: so neither is the objective than this.
    """

    radii: np.ndarray
    value: float


def bound(n: int) -> Proof:
    """Upper bounds by weak duality; it knows the constraints' data, and nothing of ``shape``.

    In u = 1/r convexity is linear: c_j(u) = u_{j-1} - 2 cosθ u_j + u_{j+1} >= 0. For each i the
    multipliers m_j = sin((i-j)θ)/sinθ >= 0, j < i, add the rows up to u_i >= const.; what is left
    on the unknowns u_1 .. u_{i-1} is charged at their largest size, 1. Then rows of the growth
    limit are added from each bound on.
    """
    theta = step(n)
    multiplier = np.sin(np.arange(n + 2) * theta) / math.sin(theta)
    assert np.all(multiplier >= 0.0)
    upper = np.empty(n)
    for i in range(1, n + 1):
        m = multiplier[i - np.arange(i)]  # on rows 0 .. i-1
        total = np.zeros(i + 2)  # on u_{-1} .. u_i
        total[:-2] += m
        total[1:-1] -= 2.0 * math.cos(theta) * m
        total[2:] += m
        left = total[2:-1]
        charged = float(np.sum(abs(left))) + 16.0 * EPS * float(np.sum(m))
        least = (-(total[0] + total[1]) - charged) / total[-1]
        upper[i - 1] = 1.0 / least if least > 1.0 / LARGEST else LARGEST
    growth = ALPHA * theta
    running = LEAST
    for i in range(n):
        running = min(upper[i], running + growth)
        upper[i] = running
    return Proof(upper, math.pi / n * math.fsum(upper))


def run(effort: Effort = FULL) -> Section:
    """Value, proof and time of every size."""
    rows = []
    for n in effort.some(SIZES):
        r = shape(n)
        reported = f"{PUBLISHED[n]:.9f}" if n in PUBLISHED else "none proven"
        time = timed(lambda n=n: shape(n), effort.repeats(50))
        above = f"{bound(n).value - value(r):.1e}"
        rows.append((str(n), f"{value(r):.9f}", reported, above, f"{breach(r):.1e}", str(time)))
    head = (">n", ">objective", ">published", ">proven bound above it by", ">worst breach", ">time")
    return Section("camshape", TEXT, [Table(head, rows)])
