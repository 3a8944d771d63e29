"""Limits on curvature: what the quick answer proves, and what a thorough proof adds and costs."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from statistics import median
from time import perf_counter
from typing import Any

from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import spread
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.state import QUICK, THOROUGH, ProofBudget, SolveState
from synthesis.spec.design_spec import DesignSpec

OMEGA = 10.0
TOLERANCE = 5e-3
LONG = 4.0  # seconds of runs after which there are no more
TEXT = """Scenes with a translating roller where curvature binds, tolerance 0.5 %. *Quick* is the
answer as it comes without being asked for more: its bound knows nothing of curvature. *Thorough*
goes on from there; what it takes is beyond the time of the quick answer. Gaps are of the base
radius, over all motion laws with a bounded jerk. A jerk of 2 is twice 32 h/β³, the least with which
the lift fits into the shorter segment."""


@dataclass(frozen=True)
class Scene:
    """A question.

    Attributes:
        angles: pressure angles of rise and return. jerk: over the least. lift: of both.
        segments: rise, dwell and return [deg]. radius, cutter: limits, 0 for none.
        smoothness: continuous derivatives of both laws. centred: the offset is 0.
    """

    name: str
    roller: float
    angles: tuple[float, float]
    jerk: float
    radius: float = 0.0
    cutter: float = 0.0
    lift: float = 30.0
    segments: tuple[float, float, float] = (60.0, 30.0, 60.0)
    smoothness: int = 2
    centred: bool = False

    def spec(self) -> DesignSpec:
        """As it is asked."""
        rise, dwell, back = self.segments
        law = {"kind": "spline", "smoothness": self.smoothness}
        cap = self.jerk * 32.0 * self.lift / (min(rise, back) * pi / 180.0) ** 3 * OMEGA**3
        lifting = {"lift_mm": self.lift, "law": law}
        program: list[dict[str, Any]] = [
            {"kind": "rise", "angle_deg": rise, **lifting},
            *([{"kind": "dwell", "angle_deg": dwell}] if dwell else []),
            {"kind": "return", "angle_deg": back, **lifting},
            {"kind": "dwell", "angle_deg": 360.0 - rise - dwell - back},
        ]
        limits: list[dict[str, Any]] = [
            {"kind": "pressure_angle", "rise_deg": self.angles[0], "return_deg": self.angles[1]},
            {"kind": "jerk", "max_mm_per_s3": cap},
            *([{"kind": "profile_radius", "min_mm": self.radius}] if self.radius else []),
            *([{"kind": "cutter_radius", "radius_mm": self.cutter}] if self.cutter else []),
        ]
        follower = {"kind": "translating_roller", "roller_radius_mm": self.roller}
        return DesignSpec.model_validate(
            {
                "speed_rpm": OMEGA * 30.0 / pi,
                "program": program,
                "follower": follower | ({"offset_mm": 0.0} if self.centred else {}),
                "limits": limits,
                "tolerance": TOLERANCE,
                "proof": "quick",
            }
        )


SCENES = (
    Scene("main job", 10.0, (30.0, 45.0), 1.5, radius=12.0),
    Scene("one-sided", 10.0, (25.0, 80.0), 1.5, radius=15.0),
    Scene("centred", 20.0, (45.0, 45.0), 2.0, radius=5.0, centred=True),
    Scene("unequal angles", 20.0, (30.0, 45.0), 2.0, radius=5.0),
    Scene("knife edge", 0.0, (45.0, 45.0), 2.0, radius=20.0),
    Scene("unequal segments", 12.0, (28.0, 50.0), 1.8, 8.0, 0.0, 24.0, (50.0, 20.0, 75.0)),
    Scene("much jerk", 10.0, (35.0, 35.0), 4.0, radius=10.0),
    Scene("no dwell above", 9.0, (32.0, 38.0), 1.6, 14.0, segments=(72.0, 0.0, 66.0)),
    Scene("C3", 6.0, (33.0, 27.0), 1.6, 17.0, 0.0, 21.0, (66.0, 30.0, 58.0), 3),
    Scene("C3, more jerk", 10.0, (30.0, 45.0), 3.0, radius=12.0, smoothness=3),
    Scene("large roller", 25.0, (38.0, 33.0), 1.9, 6.0, 0.0, 34.0, (80.0, 15.0, 90.0)),
    Scene("slow and quick", 14.0, (26.0, 48.0), 2.2, 9.0, 0.0, 26.0, (83.0, 25.0, 55.0)),
    Scene("small lift", 10.0, (30.0, 30.0), 1.7, 10.0, 0.0, 7.0, (40.0, 12.0, 47.0)),
    Scene("large lift, cutter", 15.0, (40.0, 30.0), 2.5, 10.0, 150.0, 60.0, (110.0, 40.0, 95.0)),
    Scene("radius and cutter", 8.0, (35.0, 40.0), 2.0, 10.0, 90.0, segments=(63.0, 30.0, 71.0)),
    Scene("cutter alone", 5.0, (45.0, 45.0), 4.0, cutter=60.0),
)


@dataclass(frozen=True)
class Found:
    """Both searches of a scene, and the seconds of each run."""

    quick: SolveState
    thorough: SolveState
    first: tuple[float, ...]
    both: tuple[float, ...]

    def row(self, scene: Scene) -> tuple[str, ...]:
        """As a row of the table."""
        more = [each - median(self.first) for each in self.both]
        boxes = [s.model for s in self.thorough.stages if s.stage == "implied rows"]
        limits = ((f"ρ ≥ {scene.radius:g}", scene.radius), (f"Rg {scene.cutter:g}", scene.cutter))
        kind = ", ".join(reported for reported, value in limits if value)
        best = self.thorough.incumbent
        return (
            scene.name,
            kind,
            _seconds(self.first),
            f"{100.0 * self.quick.gap_between(self.quick.incumbent, self.quick.lower):.1f} %",
            _seconds(more),
            f"{100.0 * self.thorough.gap_between(best, self.thorough.lower):.2f} %",
            "".join(boxes).removeprefix("linear and cone programs in ").removesuffix(" boxes"),
            f"{best.value:.3f}" if best else "",
        )


def _seconds(runs: list[float] | tuple[float, ...]) -> str:
    return spread(median(runs), min(runs), max(runs))


def run(effort: Effort = FULL) -> Section:
    """Every scene, quick and thorough."""
    found = [(scene, measured(scene, effort.repeats(3))) for scene in effort.some(SCENES)]
    return Section(
        "Limits on curvature, thoroughly",
        TEXT,
        [
            Table(
                (
                    "scene", "limits [mm]", ">quick", ">gap", ">thorough, more", ">gap", ">boxes",
                    ">prime radius [mm]",
                ),
                [outcome.row(scene) for scene, outcome in found],
            )
        ],
    )  # fmt: skip


def measured(scene: Scene, repeats: int) -> Found:
    """Both searches, timed."""
    spec = scene.spec()
    problem = formulate_problem(spec, spec.objectives()[0])
    quick, first = _timed(problem, repeats, proof=QUICK)
    thorough, both = _timed(problem, repeats, proof=THOROUGH)
    return Found(quick, thorough, first, both)


def _timed(
    problem: Problem, repeats: int, *, proof: ProofBudget
) -> tuple[SolveState, tuple[float, ...]]:
    seconds = list[float]()
    while len(seconds) < min(repeats, 2) or (len(seconds) < repeats and sum(seconds) < LONG):
        began = perf_counter()
        found = optimise(problem, TOLERANCE, proof=proof)
        seconds.append(perf_counter() - began)
    return found, tuple(seconds)
