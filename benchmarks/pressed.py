"""Limits on Hertz pressure: what bounds say without them, quickly and thoroughly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
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

TOLERANCE = 5e-3
LONG = 4.0  # seconds of runs after which there are no more
TEXT = """Scenes with a roller on a slide whose Hertz pressure binds; offset and base radius free
where nothing is said, jerk 1.5 times the least, tolerance 0.5 %. *Without it* is the gap to the
bound of the same question without the limit, *quick* that of the answer as it comes, *thorough*
that with `"proof": "thorough"`; gaps are of the base radius, over all motion laws with a bounded
jerk. Among them are a dwell that needs its size by itself, inertia at lift-off, and a guide's
friction."""


@dataclass(frozen=True)
class Scene:
    """A question.

    Attributes:
        limit: pressure [MPa]. segments: rise, dwell and return [deg]. lift: of both [mm].
        angles: pressure angles of rise and return. load, follower: what differs from the first.
    """

    name: str
    limit: float
    segments: tuple[float, float, float] = (70.0, 30.0, 80.0)
    lift: float = 30.0
    angles: tuple[float, float] = (30.0, 45.0)
    rpm: float = 300.0
    load: Mapping[str, Any] = field(default_factory=dict)
    follower: Mapping[str, Any] = field(default_factory=dict)

    def spec(self, *, limited: bool = True) -> DesignSpec:
        """As it is asked; ``limited``: in its pressure, too."""
        rise, dwell, back = self.segments
        cap = 1.5 * 32.0 * self.lift / (min(rise, back) * pi / 180.0) ** 3
        lifting = {"lift_mm": self.lift, "law": {"kind": "spline"}}
        program: list[dict[str, Any]] = [
            {"kind": "rise", "angle_deg": rise, **lifting},
            *([{"kind": "dwell", "angle_deg": dwell}] if dwell else []),
            {"kind": "return", "angle_deg": back, **lifting},
            {"kind": "dwell", "angle_deg": 360.0 - rise - dwell - back},
        ]
        limits: list[dict[str, Any]] = [
            {"kind": "pressure_angle", "rise_deg": self.angles[0], "return_deg": self.angles[1]},
            {"kind": "jerk", "max_mm_per_s3": cap * (self.rpm * pi / 30.0) ** 3},
            *([{"kind": "hertz_pressure", "max_mpa": self.limit}] if limited else []),
        ]
        load = {
            "kind": "slide", "moving_mass_kg": 2.0, "contact": {"width_mm": 12.0},
            "spring": {"rate_n_per_mm": 6.0, "preload_n": 400.0}, **self.load,
        }  # fmt: skip
        follower = {"kind": "translating_roller", "roller_radius_mm": 10.0, **self.follower}
        return DesignSpec.model_validate(
            {
                "speed_rpm": self.rpm, "program": program, "follower": follower, "load": load,
                "limits": limits, "tolerance": TOLERANCE,
            }
        )  # fmt: skip


PRESS = [(0.0, 0.0), (60.0, 500.0), (100.0, 500.0), (100.0, 0.0)]
SCENES = (
    Scene("press, nose", 700.0, load={
        "process": [{"angle_deg": angle, "force_n": force} for angle, force in PRESS]}),
    Scene("unequal limits, nose", 480.0, (63.0, 24.0, 88.0), 27.0, (27.0, 48.0),
          follower={"roller_radius_mm": 11.3}),
    Scene("stiff spring, nose", 600.0, load={
        "spring": {"rate_n_per_mm": 25.0, "preload_n": 150.0}}),
    Scene("offset given", 450.0, (70.0, 0.0, 90.0), follower={"offset_mm": -6.0}),
    Scene("inertia, lift-off", 600.0, rpm=900.0, angles=(38.0, 38.0), load={
        "moving_mass_kg": 1.3, "spring": {"rate_n_per_mm": 1.0, "preload_n": 100.0}}),
    Scene("dwell above", 900.0, rpm=900.0, angles=(38.0, 38.0), load={
        "moving_mass_kg": 1.3, "spring": {"rate_n_per_mm": 60.0, "preload_n": 800.0}}),
    Scene("ring", 400.0, follower={"closure": {"kind": "force", "contact": "inside"}}),
    Scene("groove, both flanks", 560.0, rpm=600.0, load={
        "moving_mass_kg": 3.0, "spring": None},
        follower={"closure": {"kind": "groove", "clearance_mm": 0.1}}),
    Scene("friction in the guide", 490.0, load={
        "friction": {"coefficient": 0.12, "overhang_mm": 60.0, "bearing_length_mm": 70.0}}),
)  # fmt: skip


@dataclass(frozen=True)
class Found:
    """The searches of a scene, and the seconds of each run."""

    without: SolveState
    quick: SolveState
    thorough: SolveState
    first: tuple[float, ...]
    both: tuple[float, ...]

    def row(self, scene: Scene) -> tuple[str, ...]:
        """As a row of the table."""
        boxes = [s.model for s in self.thorough.stages if s.stage == "implied rows"]
        best = self.thorough.incumbent
        return (
            scene.name,
            f"{scene.limit:g}",
            f"{100.0 * self.without.gap_between(self.quick.incumbent, self.without.lower):.1f} %",
            _seconds(self.first),
            f"{100.0 * self.quick.gap_between(self.quick.incumbent, self.quick.lower):.2f} %",
            _seconds(self.both),
            f"{100.0 * self.thorough.gap_between(best, self.thorough.lower):.2f} %",
            "".join(boxes).removeprefix("linear and cone programs in ").removesuffix(" boxes"),
            f"{best.value:.3f}" if best else "",
        )


def _seconds(runs: tuple[float, ...]) -> str:
    return spread(median(runs), min(runs), max(runs))


def run(effort: Effort = FULL) -> Section:
    """Every scene: without the limit, quick and thorough."""
    found = [(scene, measured(scene, effort.repeats(3))) for scene in effort.some(SCENES)]
    return Section(
        "Limits on Hertz pressure",
        TEXT,
        [
            Table(
                (
                    "scene", ">limit [MPa]", ">without it", ">quick", ">gap", ">thorough", ">gap",
                    ">boxes", ">prime radius [mm]",
                ),
                [outcome.row(scene) for scene, outcome in found],
            )
        ],
    )  # fmt: skip


def measured(scene: Scene, repeats: int) -> Found:
    """All searches, timed."""
    spec, unlimited = scene.spec(), scene.spec(limited=False)
    problem = formulate_problem(spec, spec.objectives()[0])
    quick, first = _timed(problem, repeats, proof=QUICK)
    thorough, both = _timed(problem, repeats, proof=THOROUGH)
    without = optimise(formulate_problem(unlimited, unlimited.objectives()[0]), TOLERANCE)
    return Found(without, quick, thorough, first, both)


def _timed(
    problem: Problem, repeats: int, *, proof: ProofBudget
) -> tuple[SolveState, tuple[float, ...]]:
    seconds = list[float]()
    while not seconds or (len(seconds) < repeats and sum(seconds) < LONG):
        began = perf_counter()
        found = optimise(problem, TOLERANCE, proof=proof)
        seconds.append(perf_counter() - began)
    return found, tuple(seconds)
