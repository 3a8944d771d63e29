"""A follower train's response: exact propagation against step control, error against time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.axis import Axis, relative, seconds
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from synthesis import DesignSpec
from synthesis.catalogue.motion import Motion
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.response import Steps, from_rest
from synthesis.numerics.piecewise import Array

LIFT, RISE, OMEGA, PLACES = 17.0, 80.0, 25.0, 90
SWINGS = (3.3, 33.3, 333.3)  # of the train during the rise
EXACT = "φ-functions"
TOLERANCES = {"DOP853": (1e-4, 1e-7, 1e-10), "Radau": (1e-4, 1e-7)}
LEAST = 1e-16
TEXT = """One mass on a spring, driven by a cycloidal rise, from rest: its deflection at {places}
cam angles, by the exact response of `/v1/train-responses` and by SciPy's integrators at tolerances
from 10⁻⁴ to 10⁻¹⁰. The truth is a closed form, a sum of two sines; errors are the largest at these
angles over the largest deflection. The stiffer the train (swings during the rise), the more steps
an integrator needs; the exact response takes one step per angle whatever the train is."""


@dataclass(frozen=True)
class Case:
    """A train that swings so often during the rise, and the cam."""

    swings: float

    @property
    def frequency(self) -> float:
        """ω_n [rad/s]."""
        return 2.0 * pi * self.swings / self.seconds

    @property
    def seconds(self) -> float:
        """Of the rise."""
        return np.radians(RISE) / OMEGA

    @property
    def chain(self) -> Chain:
        """Undamped."""
        one = np.ones(1)
        return Chain(one, self.frequency**2 * one, 0.0 * one, 0.0 * one, 0.0 * one)

    def truth(self, t: Array) -> Array:
        """y of y'' + ω_n² y = −A sin Ωt from rest, A = h Ω²/2π."""
        drive = 2.0 * pi / self.seconds
        share = LIFT * drive**2 / (2.0 * pi) / (self.frequency**2 - drive**2)
        swing = drive / self.frequency * np.sin(self.frequency * t)
        return np.asarray(share * (swing - np.sin(drive * t)))

    def integrated(self, method: str, tolerance: float, t: Array) -> Array:
        """By an integrator of SciPy."""
        drive, square = 2.0 * pi / self.seconds, self.frequency**2
        peak = LIFT * drive**2 / (2.0 * pi)

        def rate(time: float, x: Array) -> list[float]:
            return [x[1], -square * x[0] - peak * np.sin(drive * time)]

        scale = tolerance * float(np.max(np.abs(self.truth(t))))
        found = solve_ivp(rate, (0.0, self.seconds), [0.0, 0.0], method=method, t_eval=t,
                          rtol=tolerance, atol=[scale, scale * self.frequency])  # fmt: skip
        return np.asarray(found.y[0])


@dataclass(frozen=True)
class Outcome:
    """One method on one train; no tolerance: exact."""

    case: Case
    method: str
    tolerance: float | None
    time: Timing
    error: float


def cam() -> Motion:
    """A cycloidal rise; what follows is not looked at."""
    law = {"kind": "cycloidal"}
    program = [
        {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": law},
        {"kind": "return", "angle_deg": 360.0 - RISE, "lift_mm": LIFT, "law": law},
    ]
    follower = {"kind": "translating_roller", "roller_radius_mm": 8.0, "offset_mm": 0.0}
    body = {"program": program, "follower": follower, "base_radius_mm": 40.0}
    return Motion.of(DesignSpec.model_validate(body).placed_segments())


def run(effort: Effort = FULL) -> Section:
    """Every method on every train."""
    found = [one for swings in effort.some(SWINGS) for one in _outcomes(Case(swings), effort)]
    head = (">swings in the rise", "method", ">tolerance", ">time", ">over the exact", ">error")
    return Section(
        "Follower trains", TEXT.format(places=PLACES),
        [*(_diagram(found, swings) for swings in effort.some(SWINGS)),
         Table(head, [_row(one, found) for one in found])],
    )  # fmt: skip


def _outcomes(case: Case, effort: Effort) -> list[Outcome]:
    motion = cam()
    steps = Steps.of(motion, round(PLACES * 360.0 / RISE))
    inside = steps.theta <= np.radians(RISE) * (1.0 + 1e-12)
    t = np.minimum(steps.theta[inside] / OMEGA, case.seconds)
    truth = case.truth(t)

    def exact() -> Array:
        (turn,) = from_rest(case.chain, Steps.of(motion, len(steps.theta)), OMEGA, 1)
        return turn.deflection[0][: len(t)]

    ways: dict[tuple[str, float | None], Callable[[], Array]] = {(EXACT, None): exact}
    for method, tolerances in TOLERANCES.items():
        for tolerance in effort.some(tolerances):
            ways[method, tolerance] = lambda m=method, e=tolerance: case.integrated(m, e, t)
    calls: dict[str, Call] = {str(way): call for way, call in ways.items()}
    times = in_turns(calls, effort.repeats(3), effort.warm_up(1))
    peak = float(np.max(np.abs(truth)))
    (turn,) = from_rest(case.chain, steps, OMEGA, 1)
    found = []
    for way, call in ways.items():
        value = turn.deflection[0][inside] if way[1] is None else call()
        error = float(np.max(np.abs(value - truth))) / peak
        found.append(Outcome(case, *way, times[str(way)], error))
    return found


def _row(one: Outcome, found: list[Outcome]) -> tuple[str, ...]:
    exact = next(each for each in found if each.case == one.case and each.tolerance is None)
    tolerance = "–" if one.tolerance is None else f"{one.tolerance:.0e}"
    over = "1" if one is exact else one.time.over(exact.time)
    return (
        f"{one.case.swings:g}", one.method, tolerance, str(one.time), over, f"{one.error:.1e}"
    )  # fmt: skip


def _diagram(found: list[Outcome], swings: float) -> Diagram:
    names = dict.fromkeys(one.method for one in found)
    series = [
        Series(name, [Point(one.time.median, max(one.error, LEAST)) for one in found
                      if one.method == name and one.case.swings == swings])
        for name in names
    ]  # fmt: skip
    return Diagram(
        f"train-{swings:g}".replace(".", "-"),
        f"A train that swings {swings:g} times in the rise: error against time",
        "The exact response is one point; integrators buy error with time.",
        Axis("time", seconds), Axis("error", relative, least=LEAST), series,
    )  # fmt: skip
