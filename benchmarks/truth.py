"""What the right answers are: closed forms, and a fine reference by a method of its own.

Nothing here comes from the product's formulations. The closed forms are those of
docs/reference/exact-optima.md; the reference states the main job as a chain of states under a jerk
that is constant on each of very many intervals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import pi, radians, sqrt, tan
from typing import Any

from benchmarks.main_job import CONVEX
from synthesis.spec.design_spec import DesignSpec

LIFT, OMEGA = 17.3, 7.9  # mm, rad/s
RISE, DWELL, RETURN = 71.3, 37.9, 113.7  # deg; the return is slower, so peaks are the rise's
BETA = radians(RISE)
JERK = 53.7  # cap of the rise in h/β³
PRIME, PRIME_KNOWN_TO = 44.9968, 2e-4  # prime radius of the main job's best cam [mm]


@dataclass(frozen=True)
class Scene:
    """A question whose answer is known.

    Attributes:
        name: as the page tells it. exact: the optimum, as the certificate gives it.
        body: the request, for a smoothness of the laws. known_to: relative.
    """

    name: str
    exact: float
    body: Callable[[int], dict[str, Any]]
    known_to: float = 0.0

    def spec(self, smoothness: int = 2, **more: Any) -> DesignSpec:
        """The request."""
        return DesignSpec.model_validate(self.body(smoothness) | more)


def unit(order: int) -> float:
    """What 1 in the closed forms is worth at these sizes: h ωᵏ/βᵏ [mm/sᵏ]."""
    return LIFT * (OMEGA / BETA) ** order


def main_job(smoothness: int) -> dict[str, Any]:
    """The main job's program."""
    law = {"kind": "spline", "smoothness": smoothness}
    moving = ("rise", "return")
    program = [s | ({"law": law} if s["kind"] in moving else {}) for s in CONVEX["program"]]
    return CONVEX | {"program": program}


def motion_alone(
    objective: str, smoothness: int, jerk: float | None = None, turn: bool = False
) -> dict[str, Any]:
    """A cam so wide that nothing but the motion decides."""
    law = {"kind": "spline", "smoothness": smoothness}
    between = 0.0 if turn else DWELL
    down = RISE if turn else RETURN
    dwell = [] if turn else [{"kind": "dwell", "angle_deg": between}]
    return {
        "speed_rpm": OMEGA * 30.0 / pi,
        "program": [
            {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": law},
            *dwell,
            {"kind": "return", "angle_deg": down, "lift_mm": LIFT, "law": law},
            {"kind": "dwell", "angle_deg": 360.0 - RISE - between - down},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 4.1, "offset_mm": 0.0},
        "base_radius_mm": 30.0 * LIFT,
        "limits": [] if jerk is None else [{"kind": "jerk", "max_mm_per_s3": jerk * unit(3)}],
        "objective": {"kind": objective},
    }


BASE_RADIUS = Scene(
    "base radius of the main job", PRIME - 10.0, main_job, PRIME_KNOWN_TO / (PRIME - 10.0)
)
PEAK_ACCELERATION = Scene(
    "peak acceleration, jerk limited",
    JERK / 4.0 * (1.0 - sqrt(1.0 - 32.0 / JERK)) * unit(2),
    lambda smoothness: motion_alone("peak_acceleration", smoothness, JERK),
)
PEAK_JERK = Scene(
    "peak jerk, dwell to turn",
    6.0 * (2.0 + sqrt(2.0)) * unit(3),
    lambda smoothness: motion_alone("peak_jerk", smoothness, turn=True),
)
RMS_JERK = Scene(
    "rms jerk, dwell to dwell",
    unit(3) * sqrt(720.0 * (1.0 + (RISE / RETURN) ** 5) * BETA / (2.0 * pi)),
    lambda smoothness: motion_alone("rms_jerk", smoothness),
)
SCENES = (BASE_RADIUS, PEAK_ACCELERATION, PEAK_JERK, RMS_JERK)


def prime_radius(intervals: int) -> float:
    """Prime radius of the main job's best cam [mm], the jerk constant on each interval.

    Lengths over the lift, angles over the segment; s, v, a at the ends of the intervals are
    unknowns, joined by exact integration. The pressure angle is limited at these ends.
    """
    import cvxpy  # takes more than a second

    cp: Any = cvxpy
    size = cp.Variable(2)  # offset and height
    said = [
        row
        for limit, up in ((30.0, True), (45.0, False))
        for row in _segment(intervals, tan(radians(limit)), up, size)
    ]
    stated = cp.Problem(cp.Minimize(cp.norm(size)), said)
    stated.solve(solver=cp.CLARABEL, tol_gap_abs=1e-11, tol_gap_rel=1e-11, tol_feas=1e-11)
    return 30.0 * float(stated.value)


def _segment(n: int, t: float, up: bool, size: Any) -> Iterator[Any]:
    import cvxpy

    cp: Any = cvxpy
    s, v, a, j = (cp.Variable(n + (k < 3)) for k in range(4))
    h = 1.0 / n
    yield from (s[0] == 0.0, s[n] == 1.0, v[0] == 0.0, v[n] == 0.0, a[0] == 0.0, a[n] == 0.0)
    yield cp.abs(j) <= 1.5 * 32.0
    yield v >= 0.0
    yield a[1:] == a[:-1] + h * j
    yield v[1:] == v[:-1] + h * a[:-1] + h * h / 2.0 * j
    yield s[1:] == s[:-1] + h * v[:-1] + h * h / 2.0 * a[:-1] + h**3 / 6.0 * j
    lift, velocity = (s, v) if up else (1.0 - s, -v)
    sideways = velocity / (pi / 3.0) - size[0]
    yield cp.abs(sideways) <= t * (size[1] + lift)
