"""Print the table of exact-optima.md: exact optima of motion laws, and how near designs come.

python docs/reference/exact_optima.py
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import pi, sqrt
from typing import Any

from scipy.optimize import brentq

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design

LIFT, OMEGA = 17.3, 7.9  # mm, rad/s
RISE, DWELL, RETURN = 71.3, 37.9, 113.7  # deg; the return is slower, so peaks are the rise's
BETA = RISE * pi / 180.0
SLOWER = RETURN / RISE
TOLERANCES = (2e-3, 1e-6)
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
        smoothness: of the splines; 1 where the best law's acceleration jumps.
    """

    law: str
    objective: str
    order: int
    optimum: float
    caps: tuple[tuple[int, float], ...] = ()
    turn: bool = False
    smoothness: int = 2

    def exact(self) -> float:
        """The optimum of the whole turn, on the wire."""
        if not self.objective.startswith("rms"):
            return self.optimum * unit(self.order)
        slower = 1.0 if self.turn else SLOWER
        back = self.optimum  # of the return in its own units, in which its caps are wider
        if self.caps:
            back = rms_acceleration(self.caps[0][1] * slower**3)
        energy = self.optimum**2 + back**2 / slower ** (2 * self.order - 1)
        return unit(self.order) * sqrt(energy * BETA / (2.0 * pi))

    def spec(self, tolerance: float) -> DesignSpec:
        return question(self.turn, self.caps, self.objective, tolerance, self.smoothness)


def question(
    turn: bool,
    caps: tuple[tuple[int, float], ...],
    objective: str,
    tolerance: float,
    smoothness: int = 2,
) -> DesignSpec:
    """The question: a wide cam, so that nothing but the motion decides."""
    names = {
        1: ("velocity", "max_mm_per_s"),
        2: ("acceleration", "max_mm_per_s2"),
        3: ("jerk", "max_mm_per_s3"),
    }
    law = {"kind": "spline", "smoothness": smoothness}
    rise = {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": law}
    back = rise | {"kind": "return", "angle_deg": RISE if turn else RETURN}
    between = [] if turn else [{"kind": "dwell", "angle_deg": DWELL}]
    used = 2.0 * RISE if turn else RISE + DWELL + RETURN
    body: dict[str, Any] = {
        "speed_rpm": OMEGA * 30.0 / pi,
        "program": [rise, *between, back, {"kind": "dwell", "angle_deg": 360.0 - used}],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 4.1, "offset_mm": 0.0},
        "base_radius_mm": 30.0 * LIFT,
        "limits": [
            {"kind": names[order][0], names[order][1]: value * unit(order)} for order, value in caps
        ],
        "objective": {"kind": objective},
        "tolerance": tolerance,
    }
    return DesignSpec.model_validate(body)


def peak_acceleration(jerk: float) -> float:
    return jerk / 4.0 * (1.0 - sqrt(1.0 - 32.0 / jerk))


def rms_acceleration(jerk: float) -> float:
    return jerk * (1.0 - sqrt(1.0 - 24.0 / jerk)) / 2.0 / sqrt(3.0)


CASES = (
    Case("32", "peak_jerk", 3, 32.0),
    Case("(J/4)(1 − √(1 − 32/J)), J = 50: 5", "peak_acceleration", 2, 5.0, ((3, 50.0),)),
    Case("the same, J = 53.7", "peak_acceleration", 2, peak_acceleration(J), ((3, J),)),
    Case("4", "peak_acceleration", 2, 4.0),
    Case("4, C1", "peak_acceleration", 2, 4.0, smoothness=1),
    Case("√12", "rms_acceleration", 2, sqrt(12.0)),
    Case("√12, C1", "rms_acceleration", 2, sqrt(12.0), smoothness=1),
    Case("Jτ/√3, J = 53.7", "rms_acceleration", 2, rms_acceleration(J), ((3, J),)),
    Case("√720", "rms_jerk", 3, sqrt(720.0)),
    Case("dwell to turn: 6(2 + √2)", "peak_jerk", 3, 6.0 * (2.0 + sqrt(2.0)), turn=True),
    Case("dwell to turn: √320", "rms_jerk", 3, sqrt(320.0), turn=True),
)


@dataclass(frozen=True)
class Threshold:
    """A least peak velocity: no objective of the product, so a limit is put on either side of it.

    Attributes:
        law: the closed form, as printed.
        least: its value for unit lift and angle.
        caps: limits by derivative, in units of the rise.
        above: how little above it a limit is still met. below: how little below it none is, proven.
        smoothness: of the splines.
    """

    law: str
    least: float
    caps: tuple[tuple[int, float], ...]
    above: float
    smoothness: int = 2
    below: float = 1e-4

    @cache  # noqa: B019 - there are three, for good
    def status(self, factor: float) -> str:
        """What becomes of a limit at that multiple of the least peak velocity."""
        caps = (*self.caps, (1, self.least * factor))
        return synthesise(question(False, caps, "base_radius", 1e-4, self.smoothness)).status


THRESHOLDS = (
    Threshold(
        "V(1 − 2√(V/J)) = 1, J = 53.7",
        brentq(lambda v: v * (1.0 - 2.0 * sqrt(v / J)) - 1.0, 1.0, 2.0, xtol=1e-15),
        ((3, J),),
        1e-6,
        below=1e-6,
    ),
    Threshold(
        "V(1 − V/A − A/J) = 1, A = 5.3, J = 53.7",
        (1.0 - A / J - sqrt((1.0 - A / J) ** 2 - 4.0 / A)) * A / 2.0,
        ((2, A), (3, J)),
        1e-6,
        below=1e-6,
    ),
    Threshold("(A − √(A² − 4A))/2, A = 5.3", (A - sqrt(A * A - 4.0 * A)) / 2.0, ((2, A),), 1.2e-2),
    Threshold("the same, C1", (A - sqrt(A * A - 4.0 * A)) / 2.0, ((2, A),), 1e-4, smoothness=1),
)


@cache
def reached(case: Case, tolerance: float) -> tuple[Design, float, float]:
    """The design, its value above and its bound below the exact optimum (relative)."""
    design = synthesise(case.spec(tolerance))
    proof = design.certificate
    assert proof.value is not None
    assert proof.lower_bound is not None
    return design, proof.value / case.exact() - 1.0, 1.0 - proof.lower_bound / case.exact()


def millionths(value: float) -> str:
    return f"{round(1e6 * value, 2) + 0.0:g}"


def optima() -> Iterator[str]:
    for case in CASES:
        for tolerance in TOLERANCES:
            design, above, below = reached(case, tolerance)
            reported = "all laws" if "all" in design.certificate.bound_valid_for else "splines"
            yield (
                f"| {case.objective.replace('_', ' ')} | {case.law} | {1e6 * tolerance:.0f} "
                f"| {design.status} | {millionths(above)} | {millionths(below)} | {reported} |"
            )


def thresholds() -> Iterator[str]:
    for case in THRESHOLDS:
        yield (
            f"| {case.law} | {case.least:.6f} | {millionths(case.above)} "
            f"| {case.status(1.0 + case.above)} | {millionths(case.below)} "
            f"| {case.status(1.0 - case.below)} |"
        )


def main() -> None:
    print("| least | closed form | tolerance | status | value above | bound below | bound over |")
    print("|---|---|--:|---|--:|--:|---|")
    for row in optima():
        print(row, flush=True)
    print()
    print("| closed form | V | limit above it by | then | limit below it by | then |")
    print("|---|--:|--:|---|--:|---|")
    for row in thresholds():
        print(row, flush=True)


if __name__ == "__main__":
    main()
