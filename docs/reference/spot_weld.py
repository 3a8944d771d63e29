"""Print the tables of spot-weld.md: the conveyor spot-weld cam, and an independent global search.

python docs/reference/spot_weld.py
"""

from collections.abc import Iterator
from functools import cache
from itertools import product
from math import factorial, sqrt
from typing import Any

import numpy as np
from scipy.optimize import linprog

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design

INCH = 25.4  # mm
RPM = 58.0
PER_SECOND = 6.0 * RPM  # degrees
LIFT, CONVEYED, SPEED = 6.7, 1.1, 22.0  # in, in, in/s
DWELL = 20.0  # degrees
REST = LIFT - CONVEYED  # in, what the return moves before and after
CONVEYING = round(CONVEYED / SPEED * PER_SECOND, 9)  # degrees
FREE = 360.0 - DWELL - CONVEYING  # degrees, for rise and the rest of the return
TOLERANCE = 5e-3
ORDERS = {"peak_acceleration": 2, "peak_jerk": 3}


def spec(objective: str) -> DesignSpec:
    """The cam with every duration free, and how the return's lift is split too."""
    part: dict[str, Any] = {
        "kind": "return",
        "angle_deg": {"min": 10.0, "max": 240.0},
        "lift_mm": {"min": 0.1 * INCH, "max": 5.5 * INCH},
    }
    return DesignSpec.model_validate(
        {
            "name": "conveyor spot-weld cam",
            "speed_rpm": RPM,
            "program": [
                {"kind": "rise", "angle_deg": {"min": 60.0, "max": 260.0}, "lift_mm": LIFT * INCH},
                {"kind": "dwell", "angle_deg": DWELL},
                part,
                {
                    "kind": "constant_velocity",
                    "angle_deg": CONVEYING,
                    "velocity_mm_per_s": round(-SPEED * INCH, 9),
                },
                part,
            ],
            "follower": {"kind": "translating_roller", "roller_radius_mm": 20.0, "offset_mm": 0.0},
            "base_radius_mm": 250.0,
            "objective": {"kind": objective},
            "tolerance": TOLERANCE,
        }
    )


@cache
def designed(objective: str) -> Design:
    """The answer of Camwright."""
    return synthesise(spec(objective))


def exact_acceleration() -> float:
    """The least peak acceleration of any law [in/s²]: full speed up, full brakes, nothing between.

    A rise of h takes 2√(h/P). Down to the conveyor's speed, and from it to the turn: together
    never quicker than 2√(h/P) for what is left of the return, and as quick if one of the two does
    no more than reach that speed.
    """
    return 4.0 * (sqrt(LIFT) + sqrt(REST)) ** 2 / (FREE / PER_SECOND) ** 2


# -- the independent search: angles on a grid, for each a linear program in time ------------------


def state(cells: int, duration: float, order: int, k: int, start: list[float]) -> np.ndarray:
    """s^(k) at the ends of the cells, from a control constant on each: (cells + 1, cells + 1).

    The last column holds what the known start state (s, v, …) brings.
    """
    t = np.linspace(0.0, duration, cells + 1)
    n = order - k
    reach = np.maximum(t[:, None] - t, 0.0) ** n / factorial(n)
    known = sum(start[j] * t ** (j - k) / factorial(j - k) for j in range(k, order))
    return np.column_stack([reach[:, :-1] - reach[:, 1:], known * np.ones(cells + 1)])


@cache
@cache
def least_peak(objective: str, first: float, last: float, cells: int) -> float:
    """Least peak of the control [in/sᵏ] when the return's two parts take these angles [deg].

    The lift's split and the acceleration at the turn are unknowns of the program.
    """
    m = ORDERS[objective]
    angles = (first, last, FREE - first - last)
    starts = ([0.0, 0.0, 0.0], [0.0, -SPEED, 0.0], [0.0, 0.0, 0.0])
    ends = ([0.0, -SPEED, 0.0], [0.0, 0.0, 0.0], [LIFT, 0.0, 0.0])
    n = 3 * cells + 3  # controls, lift of the first part, acceleration at the turn, peak
    split, turn, peak = n - 3, n - 2, n - 1
    equal, rhs, below, bound = [], [], [], []
    for part, angle in enumerate(angles):
        where = slice(part * cells, (part + 1) * cells)
        duration = angle / PER_SECOND
        for k in range(m):
            table = state(cells, duration, m, k, starts[part])
            row = np.zeros((cells + 1, n))
            row[:, where] = table[:, :-1]
            if part == 2 and m == 3:  # starts with the acceleration at the turn
                row[:, turn] += np.linspace(0.0, duration, cells + 1) ** (2 - k) / factorial(2 - k)
            if k == 1:
                sense = 1.0 if part == 2 else -1.0
                below.append(-sense * row[1:-1])
                bound.append(sense * table[1:-1, -1])
            if k == 0 and part < 2:  # falls by the split, or by what is left
                row[-1, split] += 1.0 if part == 0 else -1.0
            if k == 2 and part == 1:
                row[-1, turn] -= 1.0
            equal.append(row[-1])
            rest = REST if k == 0 and part == 1 else 0.0
            rhs.append(ends[part][k] - table[-1, -1] - rest)
    control = np.hstack([np.eye(n)[: 3 * cells, : n - 1], -np.ones((3 * cells, 1))])
    mirrored = np.hstack([-control[:, :-1], control[:, -1:]])
    bounds = [(None, None)] * (3 * cells) + [(0.0, REST), (None, None), (0.0, None)]
    answer = linprog(
        np.eye(n)[peak], np.vstack([control, mirrored, *below]),
        np.concatenate([np.zeros(6 * cells), *bound]), np.array(equal), rhs, bounds,
    )  # fmt: skip
    return float(answer.fun) if answer.status == 0 else np.inf


@cache
def scanned(objective: str, cells: int = 48) -> tuple[float, float, float]:
    """The least peak over all angles and its two angles: a grid over everything, then zooms.

    Zooms begin at the three best points of the grid that are not neighbours; the best of them is
    made finer, in time as well.
    """
    step = 30.0
    grid = list(product(np.arange(step, FREE, step), repeat=2))
    grid = [(a, b) for a, b in grid if FREE - a - b >= step]
    table = sorted((least_peak(objective, a, b, 16), a, b) for a, b in grid)
    best = (np.inf, 0.0, 0.0)
    kept: list[tuple[float, float]] = []
    for _, a, b in table:
        if len(kept) < 3 and all(max(abs(a - c), abs(b - d)) > 1.5 * step for c, d in kept):
            kept.append((a, b))
            best = min(best, zoomed(objective, a, b, (step, 0.5), 16))
    return zoomed(objective, *best[1:], (1.0, 0.02), cells)


def zoomed(
    objective: str, first: float, last: float, steps: tuple[float, float], cells: int
) -> tuple[float, float, float]:
    """The best of nine points, closer and closer."""
    step, finest = steps
    best = (least_peak(objective, first, last, cells), first, last)
    while step > finest:
        _, a, b = best
        around = [(a + i * step, b + j * step) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        allowed = [(x, y) for x, y in around if min(x, y, FREE - x - y) > 1.0]
        found = min((least_peak(objective, x, y, cells), x, y) for x, y in allowed)
        if found[0] < best[0] * (1.0 - 1e-7):
            best = found
        else:
            step *= 0.5
    return best


def rows() -> Iterator[str]:
    for objective in ORDERS:
        design, (peak, a, b) = designed(objective), scanned(objective)
        proof = design.certificate
        assert proof.value is not None
        assert proof.lower_bound is not None
        first, last = (design.free_parameters[f"program/{i}/angle_deg"] for i in (2, 4))
        yield (
            f"| `{objective}` | {proof.value / INCH:.2f} | {proof.lower_bound / INCH:.2f} "
            f"| {first:.1f}° + {last:.1f}° "
            f"| {design.free_parameters['program/2/lift_mm'] / INCH:.3f} "
            f"| {peak:.2f} | {a:.1f}° + {b:.1f}° |"
        )


def main() -> None:
    print(
        "| objective | designed | bound over all angles | return before + after | lift before in "
        "| independent search | its angles |"
    )
    print("|---|" + "--:|" * 6)
    for row in rows():
        print(row, flush=True)
    print(f"exact least peak acceleration: {exact_acceleration():.2f} in/s²")


if __name__ == "__main__":
    main()
