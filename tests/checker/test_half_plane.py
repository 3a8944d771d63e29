"""Step 6 of the checker against its definition: what multipliers say of a law, summed directly.

For any law that keeps its end conditions the constant, without what the cap takes, plus ∫ ψ g^(m)
plus size · z is Σ λ (row − right-hand side). ψ, the rows and the integrals are formed here in
floating point, from the multipliers as a proof file states them.
"""

import json
import math
import random
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from synthesis import DesignSpec
from synthesis.pipeline.proof_file.checker import checker

ROLLER = {"kind": "translating_roller", "roller_radius_mm": 5.0}
FACE = {"kind": "translating_flat_face"}
LIMITS = {
    "pressure_angle": {"rise_deg": 30.0, "return_deg": 40.0, "dwell_deg": 35.0},
    "velocity": {"max_mm_per_s": 900.0},
    "acceleration": {"max_mm_per_s2": 40000.0},
    "jerk": {"max_mm_per_s3": 2e6},
    "profile_radius": {"min_mm": 4.0},
    "face_width": {"left_mm": 40.0, "right_mm": 50.0},
}
RATE = 6.0 * 90.0
C = math.pi / 180.0
NODES, SHARES = np.polynomial.legendre.leggauss(7)  # exact to degree 13
GAUSS = 0.5 * (NODES + 1.0), 0.5 * SHARES  # on [0, 1]


def question(follower: Any, kinds: list[str], middle: Any) -> Any:
    """A rise, a middle, a return and a dwell."""
    gained = sum(m.get("lift_mm", 0.0) for m in middle)
    law, lift = {"kind": "spline", "overshoot": gained > 0.0}, 20.0 + gained
    body = {
        "speed_rpm": 90.0,
        "program": [
            {"kind": "rise", "angle_deg": 70.0, "lift_mm": 20.0, "law": law},
            *middle,
            {"kind": "return", "angle_deg": 80.0, "lift_mm": lift, "law": law},
            {"kind": "dwell", "angle_deg": 210.0 - sum(m["angle_deg"] for m in middle)},
        ],
        "follower": follower,
        "limits": [{"kind": kind, **LIMITS[kind]} for kind in kinds],
        "base_radius_mm": {"max": 80.0},
    }
    return DesignSpec.model_validate(body).model_dump(mode="json")


def quintic(chance: random.Random, v: float, a: float) -> np.polynomial.Polynomial:
    """A law from 0 to 1 that starts at rest and ends with v and a."""
    table = np.array([[1.0, 1.0, 1.0], [3.0, 4.0, 5.0], [6.0, 12.0, 20.0]])
    free = chance.uniform(-1.0, 1.0)  # of x³ (1 − x)³
    own = np.zeros(6)
    own[3:] = np.linalg.solve(table, [1.0, v, a])
    more = np.polynomial.Polynomial([0, 0, 0, 1]) * np.polynomial.Polynomial([1, -1]) ** 3
    return np.polynomial.Polynomial(own) + free * more


def is_free(segment: Any) -> bool:
    return segment.get("law", {}).get("kind") == "spline"


def multipliers(chance: random.Random, asked: Any, order: int) -> Any:
    parts = []
    for index, segment in enumerate(asked["program"]):
        free, rows = is_free(segment), []
        may = free and not segment["law"]["overshoot"]
        places = [(f"limits/{k}", limit["kind"]) for k, limit in enumerate(asked["limits"])]
        for place, kind in [*places, ("forward", "forward")]:
            of_top = {"jerk": 3, "acceleration": 2, "profile_radius": 2}.get(kind, 1)
            if of_top >= order or (kind == "forward" and not may):
                continue
            points = [[round(chance.random(), 3), round(chance.random(), 3)] for _ in range(3)]
            points += [[0.0, 0.25], [1.0, 0.5]]
            densities = [[0.2, 0.45, 0.3, 0.7], [0.0, 1.0, 0.0, 0.4]] if free else []
            side = 1 if kind in ("profile_radius", "forward") else chance.choice((1, -1))
            rows.append({"limit": place, "side": side, "multipliers": points + densities})
        ends = [round(chance.uniform(-2.0, 2.0), 3) for _ in range(order)] if free else []
        parts.append({"segment": index, "rows": rows, "ends": ends})
    return {"order": order, "segments": parts}


def row(asked: Any, limit: Any, side: int, sense: str, s: Any, z: Any) -> float:
    """Left less right side of a limit's row, as docs/proof.md states it."""
    kind = limit["kind"]
    if kind == "velocity":
        return float(side * s[1] - limit["max_mm_per_s"] / RATE)
    if kind == "acceleration":
        return float(side * s[2] - limit["max_mm_per_s2"] / RATE**2)
    if kind == "pressure_angle":
        slope = math.tan(math.radians(limit[f"{sense}_deg"]))
        return float(side * (s[1] - z[0]) - C * slope * (s[0] + z[1]))
    if kind == "profile_radius":
        lean = math.cos(math.radians(asked["follower"]["tilt_deg"]))
        return float(-s[2] - C * C * (s[0] + z[1] - limit["min_mm"] / lean))
    tilt, offset = math.radians(asked["follower"]["tilt_deg"]), asked["follower"]["offset_mm"]
    reach = limit["right_mm" if side > 0 else "left_mm"] / math.cos(tilt)
    at = s[1] - C * ((s[0] + z[1]) * math.tan(tilt) + offset / math.cos(tilt) ** 2)
    return float(side * at - C * reach)


@pytest.mark.parametrize("seed", range(7))
def test_multiplied_rows_are_what_they_say_of_any_law(seed: int) -> None:
    chance = random.Random(seed)
    order = 2 if seed == 5 else 3
    roller = seed % 2 == 0
    kinds = ["pressure_angle", "velocity"] if roller else ["profile_radius", "face_width"]
    kinds += ["acceleration", "jerk"] if order == 3 else ["acceleration"]
    middle = [{"kind": "dwell", "angle_deg": 30.0}] if seed < 4 else []
    if seed == 4:
        middle = [{"kind": "constant_velocity", "angle_deg": 10.0, "lift_mm": 2.0}]
    elif seed == 6:  # a given law whose acceleration is 6 h/d² at its start and −6 h/d² at its end
        law = {"kind": "cubic_2_3"}
        middle = [{"kind": "rise", "angle_deg": 30.0, "lift_mm": 4.0, "law": law}]
    asked = question(ROLLER if roller else FACE, kinds, middle)
    if seed in (1, 3):
        asked["follower"] |= {"tilt_deg": 20.0 * (2 - seed), "offset_mm": 7.5}
    witness = multipliers(chance, asked, order)
    # the checker's constant, without what the cap takes: a limit of 0 has no share
    judge = checker()
    judge.spent.clear()
    body = judge.read(json.dumps({"question": asked, "witness": witness}).encode())
    limits = {limit["kind"]: limit for limit in body["question"]["limits"]}
    cap = {2: ("acceleration", "max_mm_per_s2"), 3: ("jerk", "max_mm_per_s3")}[order]
    limits[cap[0]][cap[1]] = Fraction(0)
    constant, size = judge.half_plane(judge.Question(body["question"]), body["witness"])
    # laws that meet their neighbours, and any size
    speed = 2.0 / 10.0 if seed == 4 else 0.0  # mm per degree
    bend = 6.0 * 4.0 / 30.0**2 if seed == 6 else 0.0  # mm per degree²
    z = np.array([0.07, 31.0]) if roller else np.array([0.0, 25.0])
    left, right, level = float(constant) + float(np.dot(np.array(size, dtype=float), z)), 0.0, 0.0
    for part, segment in zip(witness["segments"], asked["program"], strict=True):
        d, free = segment["angle_deg"], is_free(segment)
        h = (segment.get("lift_mm") or 0.0) * (-1.0 if segment["kind"] == "return" else 1.0)
        g = np.polynomial.Polynomial([0.0, 1.0])
        if free:
            g = quintic(chance, speed * d / h, bend * d**2 / h)
        elif "law" in segment:
            g = np.polynomial.Polynomial([0.0, 0.0, 3.0, -2.0])
        if free and h < 0.0:  # the mirror image in time
            g = 1.0 - g(np.polynomial.Polynomial([1.0, -1.0]))
        sense = "rise" if h > 0.0 else "return" if h < 0.0 else "dwell"

        def s(x: float, g: Any = g, h: float = h, d: float = d, level: float = level) -> Any:
            return [level + h * g(x), *(h / d**k * g.deriv(k)(x) for k in (1, 2))]

        def value(x: float, group: Any, sense: str = sense, s: Any = s, h: float = h) -> float:
            if group["limit"] == "forward":
                return float(-h * s(x)[1])
            limit = asked["limits"][int(group["limit"][7:])]
            return row(asked, limit, group["side"], sense, s(x), z)

        for group in part["rows"]:
            for x, *more in group["multipliers"]:
                if len(more) == 1:
                    right += more[0] * value(x, group)
                    continue
                y, low, high = more
                for u, share in zip(*GAUSS, strict=True):
                    at, rho = x + (y - x) * u, low + (high - low) * u
                    right += (y - x) * share * rho * value(at, group)
        if free:
            left += integral(judge, part, body, asked, order, g, h, d)
        level += h
    assert left == pytest.approx(right, rel=1e-9, abs=1e-9)


def integral(
    judge: Any, part: Any, body: Any, asked: Any, order: int, g: Any, h: float, d: float
) -> float:
    """∫ ψ g^(m) of a free law, ψ from the multipliers by its definition."""
    own = judge.Question(body["question"])
    segment = own.program[part["segment"]]
    groups = []
    for group in part["rows"]:
        alpha, _, _ = own.row(segment, own.limits[group["limit"]], group["side"])
        factors = [float(f) * h / d**k for k, f in enumerate(alpha)]
        groups.append((factors, group["multipliers"]))

    def psi(tau: float) -> float:
        total = sum(
            nu * (1.0 - tau) ** (order - 1 - k) / math.factorial(order - 1 - k)
            for k, nu in enumerate(part["ends"])
        )
        for factors, entries in groups:
            for k in range(order):
                n = order - 1 - k
                for x, *more in entries:
                    if len(more) == 1 and x > tau:
                        total += more[0] * factors[k] * (x - tau) ** n / math.factorial(n)
                    elif len(more) == 3 and more[0] > tau:
                        y, low, high = more
                        start = max(x, tau)
                        at = start + (y - start) * GAUSS[0]
                        rho = low + (high - low) * (at - x) / (y - x)
                        mass = (y - start) * GAUSS[1] * rho * (at - tau) ** n
                        total += factors[k] * float(np.sum(mass)) / math.factorial(n)
        return float(total)

    cuts = sorted({0.0, 1.0, *(x for _, e in groups for x, *m in e),
                   *(m[0] for _, e in groups for x, *m in e if len(m) == 3)})  # fmt: skip
    total, control = 0.0, g.deriv(order)
    for a, b in pairwise(cuts):
        for u, share in zip(*GAUSS, strict=True):
            tau = a + (b - a) * u
            total += (b - a) * share * psi(tau) * float(control(tau))
    return total


def test_slopes_of_densities_are_rounded_upwards() -> None:
    # a velocity is 0 at the ends of a rise between dwells: what is left is −mass · right-hand side
    dwell = [{"kind": "dwell", "angle_deg": 30.0}]
    asked = question(ROLLER, ["velocity", "jerk", "pressure_angle"], dwell)
    rows = [{"limit": "limits/0", "side": 1, "multipliers": [[0, 0.3, 1, 0]]}]
    witness = {"order": 3, "segments": [{"segment": 0, "rows": rows, "ends": []}]}
    judge = checker()
    judge.spent.clear()
    body = judge.read(json.dumps({"question": asked, "witness": witness}).encode())
    body["question"]["limits"][1]["max_mm_per_s3"] = Fraction(0)
    constant, _ = judge.half_plane(judge.Question(body["question"]), body["witness"])
    exact = Fraction(-15, 100) * Fraction(900, 540)
    assert exact - Fraction(1, 10**30) < constant < exact


def test_the_integral_of_the_size_of_psi_is_exact_to_a_billionth_and_not_below() -> None:
    judge, chance = checker(), random.Random(3)
    judge.spent.clear()
    kernels = {Fraction(round(chance.random(), 3)).limit_denominator(1000):
               [Fraction(chance.randint(-50, 50)) for _ in range(5)] for _ in range(9)}  # fmt: skip
    area, _ = judge.remainder(kernels, Fraction(1), Fraction(0))
    cuts = sorted({0.0, 1.0, *map(float, kernels)})

    def psi(tau: float) -> float:
        return sum(float(c) * (float(x) - tau) ** n / math.factorial(n)
                   for x, row in kernels.items() if x > tau for n, c in enumerate(row))  # fmt: skip

    parts = (quad(lambda t: abs(psi(t)), a, b, limit=500, epsabs=1e-12)[0]
             for a, b in pairwise(cuts))  # fmt: skip
    exact = sum(parts)
    assert exact * (1.0 - 1e-9) <= float(area) <= exact * (1.0 + 1e-8)
