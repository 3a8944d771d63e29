"""Print the table of exact-optima.md: exact optima of motion laws, and how near designs come.

python docs/reference/exact_optima.py
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

from scipy.optimize import brentq

from synthesis import DesignSpec, synthesise
from synthesis.design import Design

LIFT, OMEGA = 17.3, 7.9  # mm, rad/s
RISE, DWELL, RETURN = 71.3, 37.9, 113.7  # deg; the return is slower, so peaks are the rise's
BETA = RISE * pi / 180.0
SLOWER = RETURN / RISE
TOLERANCES = (2e-3, 1e-4)
A, J = 5.3, 53.7  # caps of the rise in h/β² and h/β³


def unit(order: int) -> float:
    """What 1 in the closed forms is worth at these sizes: h ωᵏ/βᵏ [mm/sᵏ]."""
    return LIFT * (OMEGA / BETA) ** order


@dataclass(frozen=True)
class Case:
    """One closed form, for unit lift and angle.

    Attributes:
        law: the closed form, as printed.
        objective: what is made small, as on the wire.
        order: which derivative of s it is.
        optimum: exact least value of the rise alone.
        caps: limits by derivative, in units of the rise.
        turn: rise and return alike with no dwell between them.
    """

    law: str
    objective: str
    order: int
    optimum: float
    caps: tuple[tuple[int, float], ...] = ()
    turn: bool = False

    def exact(self) -> float:
        """The optimum of the whole turn on the wire."""
        if not self.objective.startswith("rms"):
            return self.optimum * unit(self.order)
        back = 1.0 if self.turn else rms_of(self, SLOWER) ** 2 / SLOWER ** (2 * self.order - 1)
        mean = (self.optimum**2 + back) if not self.turn else 2.0 * self.optimum**2
        return unit(self.order) * sqrt(mean * BETA / (2.0 * pi))

    def spec(self, tolerance: float) -> DesignSpec:
        return asked(self.turn, self.caps, self.objective, tolerance)


def asked(
    turn: bool, caps: tuple[tuple[int, float], ...], objective: str, tolerance: float
) -> DesignSpec:
    """The question: a wide cam, so that nothing but the motion decides."""
    names = {
        1: ("velocity", "max_mm_per_s"),
        2: ("acceleration", "max_mm_per_s2"),
        3: ("jerk", "max_mm_per_s3"),
    }
    rise = {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT}
    back = {"kind": "return", "angle_deg": RISE if turn else RETURN, "lift_mm": LIFT}
    between = [] if turn else [{"kind": "dwell", "angle_deg": DWELL}]
    used = RISE + back["angle_deg"] + (0.0 if turn else DWELL)
    body: dict[str, Any] = {
        "speed_rpm": OMEGA * 30.0 / pi,
        "program": [rise, *between, back, {"kind": "dwell", "angle_deg": 360.0 - used}],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 4.1, "offset_mm": 0.0},
        "base_radius_mm": 30.0 * LIFT,
        "limits": [
            {"kind": names[order][0], names[order][1]: value * unit(order)}
            for order, value in caps
        ],
        "objective": {"kind": objective},
        "tolerance": tolerance,
    }
    return DesignSpec.model_validate(body)


def rms_of(case: Case, slower: float) -> float:
    """The rms form on the return: its caps, in its own units, are wider."""
    if not case.caps:
        return case.optimum
    return rms_acceleration(case.caps[0][1] * slower**3)


def peak_acceleration(jerk: float) -> float:
    return jerk / 4.0 * (1.0 - sqrt(1.0 - 32.0 / jerk))


def rms_acceleration(jerk: float) -> float:
    return jerk * (1.0 - sqrt(1.0 - 24.0 / jerk)) / 2.0 / sqrt(3.0)


CASES = (
    Case("32", "peak_jerk", 3, 32.0),
    Case("(J/4)(1 − √(1 − 32/J)), J = 50: 5", "peak_acceleration", 2, 5.0, ((3, 50.0),)),
    Case("the same, J = 53.7", "peak_acceleration", 2, peak_acceleration(J), ((3, J),)),
    Case("4", "peak_acceleration", 2, 4.0),
    Case("√12", "rms_acceleration", 2, sqrt(12.0)),
    Case("Jτ/√3, J = 53.7", "rms_acceleration", 2, rms_acceleration(J), ((3, J),)),
    Case("√720", "rms_jerk", 3, sqrt(720.0)),
    Case("dwell to turn: 6(2 + √2)", "peak_jerk", 3, 6.0 * (2.0 + sqrt(2.0)), turn=True),
    Case("dwell to turn: √320", "rms_jerk", 3, sqrt(320.0), turn=True),
)

# least peak velocity: no objective, so a limit is put just above and just below it
VELOCITY = {
    "(A − √(A² − 4A))/2, A = 5.3": (((2, A),), (A - sqrt(A * A - 4.0 * A)) / 2.0),
    "V(1 − 2√(V/J)) = 1, J = 53.7": (
        ((3, J),),
        brentq(lambda v: v * (1.0 - 2.0 * sqrt(v / J)) - 1.0, 1.0, 2.0, xtol=1e-15),
    ),
    "V(1 − V/A − A/J) = 1, both": (
        ((2, A), (3, J)),
        (1.0 - A / J - sqrt((1.0 - A / J) ** 2 - 4.0 / A)) * A / 2.0,
    ),
}


def reached(case: Case, tolerance: float) -> tuple[Design, float, float]:
    """The design, how far its value lies above the exact optimum, and its bound below (relative)."""
    design = synthesise(case.spec(tolerance))
    proof = design.certificate
    value, bound = proof.value, proof.lower_bound
    assert value is not None and bound is not None
    return design, value / case.exact() - 1.0, 1.0 - bound / case.exact()


def velocity(caps: tuple[tuple[int, float], ...], least: float, tolerance: float) -> list[str]:
    """Answers to a velocity limit that much above and below the least peak velocity."""
    return [
        synthesise(asked(False, (*caps, (1, least * factor)), "base_radius", 1e-2)).status
        for factor in (1.0 + tolerance, 1.0 - tolerance)
    ]


def rows() -> Iterator[str]:
    for case in CASES:
        for tolerance in TOLERANCES:
            design, above, below = reached(case, tolerance)
            yield (
                f"| {case.objective.replace('_', ' ')} | {case.law} | {tolerance:g} "
                f"| {design.status} | {above:.1e} | {below:.1e} | {design.certificate.gap:.1e} |"
            )


def main() -> None:
    print("| least | closed form | tolerance | status | value above | bound below | gap stated |")
    print("|---|---|--:|---|--:|--:|--:|")
    for row in rows():
        print(row, flush=True)


if __name__ == "__main__":
    main()
