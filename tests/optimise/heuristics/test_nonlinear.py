"""The nonlinear rung: scenes where a limit that is not convex bites, measured on the pitch curve.

Curvature is taken from differences of reported positions, and optimality from a linear program
over differences of measured curvature: neither knows the formulas that IPOPT was given.
"""

import time
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from synthesis.catalogue.profile import cam_profile
from synthesis.numerics import clock
from synthesis.numerics.solvers import ipopt
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.heuristics.ipopt_search import NonlinearSolution, solve_ipopt
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.recovery.candidate import enlarge_until_feasible, recover_cam
from synthesis.spec.design_spec import DesignSpec
from tests.numerics.geometry.slopes import slopes
from tests.optimise.scenes import angles, dwell, fall, jerk, moved, problem, rise, scene

INSIDE = np.linspace(0.01, 0.99, 33)  # of a piece


@dataclass(frozen=True)
class Answer:
    model: ConicModel
    start: np.ndarray
    relaxed: float
    found: NonlinearSolution

    @property
    def size(self) -> tuple[float, ...]:
        return self.model.recover(self.found.x)[1]

    @property
    def prime(self) -> float:
        return float(np.hypot(*self.size))


def radius(least: float) -> dict[str, Any]:
    return {"kind": "profile_radius", "min_mm": least}


def cutter(largest: float) -> dict[str, Any]:
    return {"kind": "cutter_radius", "radius_mm": largest}


def planned(spec: DesignSpec, intervals: int = 10) -> tuple[ConicModel, np.ndarray, float]:
    """The relaxation, the cam it becomes when raised out of the smooth limits, and its value."""
    question = problem(spec)
    model = formulate(question, [uniform_grid(segment, intervals) for segment in question.free])
    relaxed = solve(model.program)
    laws, size = model.recover(relaxed.x)
    raised = enlarge_until_feasible(recover_cam(question, laws, size))
    start = relaxed.x if raised is None else model.point(raised.laws, raised.size)
    return model, start, float(np.hypot(*size))


def answer(spec: DesignSpec, intervals: int = 10, **how: Any) -> Answer:
    model, start, relaxed = planned(spec, intervals)
    return Answer(model, start, relaxed, solve_ipopt(model, start, **how))


def curvature(model: ConicModel, x: np.ndarray) -> np.ndarray:
    """Signed curvature of the pitch curve inside every knot interval, by differences [1/mm]."""
    laws, size = model.recover(x)
    motion = moved(model.problem, laws)
    breaks = motion.curve.breaks
    width = np.diff(breaks)[:, None]
    theta = (breaks[:-1, None] + width * INSIDE).ravel()
    reach = (width * np.minimum(INSIDE, 1.0 - INSIDE)).ravel()

    def pitch(at: np.ndarray) -> np.ndarray:
        profile = cam_profile(motion, model.problem.machine.follower, size, "ccw", at)
        return np.stack([profile.pitch_x, profile.pitch_y])

    (dx, dy), (ax, ay) = slopes(pitch, theta, np.minimum(reach, 0.01))
    return np.asarray((dy * ax - dx * ay) / np.hypot(dx, dy) ** 3)


def excess(spec: DesignSpec, model: ConicModel, x: np.ndarray) -> np.ndarray:
    """Relative amounts by which measured curvature exceeds the limits asked for."""
    measured, found = curvature(model, x), []
    for limit in spec.all_limits():
        roller = spec.follower.roller_radius_mm
        if limit.kind == "profile_radius":
            found.append((roller + limit.min_mm) * measured - 1.0)
        if limit.kind == "cutter_radius":
            found.append(-(limit.radius_mm - roller) * measured - 1.0)
    return np.concatenate(found)


def rows_broken(model: ConicModel, x: np.ndarray) -> float:
    program = model.program
    slack = program.rhs - program.matrix @ x
    first, last = program.equalities, program.equalities + program.inequalities
    return max(float(np.max(np.abs(slack[:first]), initial=0.0)), -float(np.min(slack[first:last])))


def local_gain(spec: DesignSpec, found: Answer, reach: float = 1e-3) -> float:
    """How much of its value the radius could still lose to first order, all rows linearised."""
    model, x, program = found.model, found.found.x, found.model.program
    unknowns, step = model.size.stop, 1e-5
    at = excess(spec, model, x)
    columns = []
    for k in range(unknowns):
        ahead, behind = x.copy(), x.copy()
        ahead[k], behind[k] = x[k] + step, x[k] - step
        columns.append((excess(spec, model, ahead) - excess(spec, model, behind)) / (2.0 * step))
    matrix = program.matrix.toarray()[:, :unknowns]
    slack = program.rhs - program.matrix @ x
    first, last = program.equalities, program.equalities + program.inequalities
    gradient = np.zeros(unknowns)
    gradient[model.size] = np.array(found.size) / found.prime * model.scales.size
    best = linprog(
        gradient,
        np.vstack([matrix[first:last], np.stack(columns, axis=1)]),
        np.concatenate([slack[first:last], -at]),
        matrix[:first] if first else None,
        slack[:first] if first else None,
        (-reach, reach),
    )
    assert best.status == 0, best.message
    return -float(best.fun) / found.prime


def symmetric(scale: float = 1.0, offset: Any = 0.0) -> DesignSpec:
    """Mathematics §5: 30 mm over 60° and back, 45°/45°, Rr 20, radius 5, jerk 2 × 32h/β³."""
    lift = 30.0 * scale
    program = [rise(60.0, lift), dwell(30.0), fall(60.0, lift), dwell(210.0)]
    limits = [angles(45.0, 45.0), jerk(64.0, 60.0, lift), radius(5.0 * scale)]
    return scene(program, *limits, roller=20.0 * scale, offset=offset)


UNEVEN = [rise(63.0), dwell(24.0), fall(71.0), dwell(202.0)]
SCENES: dict[str, DesignSpec] = {
    "symmetric": symmetric(),
    "offset free": symmetric(offset=None),
    "unequal angles": scene(UNEVEN, angles(30.0, 45.0), jerk(70.0, 63.0), radius(8.0), roller=17.0),
    "knife edge": scene(UNEVEN, angles(45.0, 45.0), jerk(64.0, 63.0), radius(19.0), roller=0.0),
    "undercut alone": scene(UNEVEN, angles(45.0, 45.0), jerk(64.0, 63.0), roller=27.0),
    "hollow flank": scene(UNEVEN, angles(45.0, 45.0), jerk(128.0, 63.0), cutter(57.0), roller=5.0),
    "both": scene(
        UNEVEN, angles(45.0, 45.0), jerk(64.0, 63.0), radius(20.0), cutter(150.0), roller=5.0
    ),
    "no dwell between": scene(
        [rise(64.0), fall(75.0), dwell(221.0)], angles(35.0, 45.0), jerk(90.0, 64.0), radius(12.0)
    ),
    "one law given": scene(
        [rise(63.0), dwell(24.0), fall(71.0, law="cycloidal"), dwell(202.0)],
        angles(40.0, 45.0), jerk(70.0, 63.0), radius(14.0),
    ),
}  # fmt: skip


@cache
def solved(name: str, intervals: int = 10) -> Answer:
    return answer(SCENES[name], intervals)


@pytest.mark.parametrize("name", SCENES)
def test_the_relaxation_breaks_the_limit_and_the_answer_keeps_it_tightly(name: str):
    spec, found = SCENES[name], solved(name)
    assert found.found.stopped is StopReason.SOLVED
    relaxed = solve(found.model.program).x
    assert np.max(excess(spec, found.model, relaxed)) > 1e-2
    assert -2e-3 < np.max(excess(spec, found.model, found.found.x)) <= 1e-7
    assert rows_broken(found.model, found.found.x) <= 2e-9


@pytest.mark.parametrize("name", SCENES)
def test_it_lies_between_the_relaxation_and_the_cam_that_was_raised(name: str):
    found = solved(name)
    raised = float(np.hypot(*found.model.recover(found.start)[1]))
    assert found.relaxed * (1.0 - 1e-8) < found.prime < raised


@pytest.mark.parametrize("name", SCENES)
def test_no_small_step_makes_it_smaller(name: str):
    assert local_gain(SCENES[name], solved(name)) <= 1e-4


@pytest.mark.parametrize("name", ["symmetric", "unequal angles", "hollow flank"])
def test_other_starts_end_at_the_same_cam(name: str):
    found = solved(name)
    rng = np.random.default_rng(7)
    start = found.start.copy()
    start[: found.model.size.start] += 0.03 * rng.standard_normal(found.model.size.start)
    start[found.model.size] *= rng.uniform(0.7, 1.3)
    again = solve_ipopt(found.model, start)
    assert np.hypot(*found.model.recover(again.x)[1]) == pytest.approx(found.prime, rel=2e-5)


def test_the_scene_of_the_method():
    # relaxation 28.38 mm and answer 36.38 mm: between 14 and 15 intervals of cubics
    fewer, more = solved("symmetric", 14), solved("symmetric", 15)
    assert more.relaxed < 28.38 < fewer.relaxed
    assert more.prime < 36.38 < fewer.prime


def test_finer_knots_make_it_smaller():
    primes = [solved("symmetric", intervals).prime for intervals in (8, 15, 20)]
    assert primes[0] > primes[1] > primes[2]


@pytest.mark.parametrize("scale", [1e-4, 1e3])
def test_scale_does_not_matter(scale: float):
    found = answer(symmetric(scale))
    assert found.prime / scale == pytest.approx(solved("symmetric").prime, rel=1e-6)


@pytest.mark.parametrize("law", ["cycloidal", "modified_sine", "parabolic"])
def test_a_given_law_has_the_size_that_a_search_over_two_numbers_finds(law: str):
    program = [rise(63.0, law=law), dwell(24.0), fall(71.0, law=law), dwell(202.0)]
    spec = scene(program, angles(30.0, 45.0), radius(14.0))
    found = answer(spec)
    motion = moved(found.model.problem, ())
    theta = np.union1d(np.linspace(0.0, 2.0 * np.pi, 6001), motion.curve.breaks)
    sides = [motion.derivatives(theta, 3, side) for side in ("left", "right")]
    s = np.concatenate(sides, axis=1)
    slope = np.tan(np.radians(np.where(s[1] > 0.0, 30.0, 45.0)))

    def needed(e: float) -> float:
        """Smallest s0 with this offset, by bisection on all limits."""
        low, high = 0.0, 1e4
        for _ in range(45):
            s0 = 0.5 * (low + high)
            X, u = s0 + s[0], s[1] - e
            kappa = (X**2 + u * (2.0 * s[1] - e) - X * s[2]) / (X**2 + u**2) ** 1.5
            free = s[1] == 0.0
            holds = np.max(kappa) <= 1.0 / 23.1 and np.all(free | (np.abs(u) <= slope * X))
            low, high = (low, s0) if holds else (s0, high)
        return high

    best = minimize(lambda e: np.hypot(e[0], needed(e[0])), [found.size[0]], method="Nelder-Mead")
    assert found.prime == pytest.approx(float(best.fun), rel=1e-5)


@pytest.mark.parametrize("objective", ["rms_jerk", "rms_acceleration", "peak_jerk"])
def test_a_given_size_makes_the_law_give_way(objective: str):
    spec = scene(
        UNEVEN, angles(60.0, 60.0), radius(13.0), objective=objective, base=30.0, roller=20.0
    )
    found = answer(spec)
    assert np.max(excess(spec, found.model, found.start)) > 1e-3, "nothing bites"
    assert found.found.stopped is StopReason.SOLVED
    assert found.prime == pytest.approx(50.0, rel=1e-9)
    assert -1e-3 < np.max(excess(spec, found.model, found.found.x)) <= 1e-7
    assert rows_broken(found.model, found.found.x) <= 2e-9


def test_a_size_that_touches_its_own_bounds_does_not_confuse():
    # prime radius 50 exactly, offset 0 best: there s0 ≤ 50 has the ball's own tangent
    spec = scene(
        UNEVEN, angles(60.0, 60.0), radius(5.0), objective="rms_acceleration", base=30.0,
        roller=20.0,
    )  # fmt: skip
    assert answer(spec).found.stopped is StopReason.SOLVED


@pytest.mark.parametrize(
    "objective", ["base_radius", "rms_jerk", "rms_acceleration", "peak_jerk", "peak_acceleration"]
)
def test_where_nothing_bites_it_agrees_with_the_cone_program(objective: str):
    limits = [angles(20.0, 25.0), jerk(70.0, 63.0)]
    model, start, _ = planned(
        scene(UNEVEN, *limits, objective=objective, roller=2.0, base={"max": 200.0}), 11
    )
    laws, size = model.recover(start)
    distorted = model.point(laws, tuple(1.1 * value for value in size))
    found = solve_ipopt(model, distorted)
    program = model.program
    both = program.quadratic + program.quadratic.T
    both.setdiag(program.quadratic.diagonal())

    def value(x: np.ndarray) -> float:
        return float(0.5 * x @ (both @ x) + program.linear @ x)

    best = value(solve(program).x)
    assert value(found.x) == pytest.approx(best, rel=1e-7)


def test_the_least_prime_radius_holds_with_the_offset_free():
    spec = scene(UNEVEN, angles(30.0, 45.0), jerk(70.0, 63.0), base={"min": 70.0, "max": 300.0})
    found = answer(spec)
    assert found.relaxed < 70.0
    assert found.prime == pytest.approx(79.1, rel=1e-8)


def test_the_objective_is_told_in_the_plans_own_unknown():
    found = solved("unequal angles")
    assert found.model.epigraph is not None
    reported = found.found.x[found.model.epigraph] * found.model.scales.size
    assert reported == pytest.approx(found.prime, rel=1e-12)


def test_an_impossible_scene_is_not_called_solved():
    spec = scene(
        UNEVEN, angles(45.0, 45.0), jerk(64.0, 63.0), radius(25.0), roller=20.0, base={"max": 25.0}
    )
    found = answer(spec)
    assert found.found.stopped in (StopReason.INFEASIBLE, StopReason.FAILED)
    assert np.array_equal(
        found.found.x[: found.model.size.stop], found.start[: found.model.size.stop]
    )


def test_a_larger_allowance_costs_no_more_than_itself():
    exact = solved("unequal angles")
    quick = solve_ipopt(exact.model, exact.start, tighten=1e-4)
    prime = float(np.hypot(*exact.model.recover(quick.x)[1]))
    assert exact.prime < prime < exact.prime * (1.0 + 2e-4)
    assert quick.iterations < exact.found.iterations


@pytest.mark.parametrize("factors", [(36.0, 45.0), (45.0, 36.0)])
def test_limits_of_one_kind_all_count(factors: tuple[float, float]):
    """From above and from below they are one row for IPOPT, each with its own opposite."""
    caps = [jerk(factor, 71.7) for factor in factors]
    program = (rise(71.7), dwell(23.9), fall(83.3), dwell(181.1))
    found = answer(scene(program, angles(41.3, 39.7), *caps, radius(31.0)))
    once = answer(scene(program, angles(41.3, 39.7), jerk(36.0, 71.7), radius(31.0)))
    assert once.prime > 1.05 * once.relaxed
    assert found.prime == pytest.approx(once.prime, rel=1e-6)
    assert rows_broken(found.model, found.found.x) < 1e-8


def test_a_coarser_accuracy_saves_iterations_and_keeps_the_rows():
    exact = solved("unequal angles")
    quick = solve_ipopt(exact.model, exact.start, accuracy=1e-6)
    prime = float(np.hypot(*exact.model.recover(quick.x)[1]))
    assert prime == pytest.approx(exact.prime, rel=1e-4)
    assert quick.iterations < exact.found.iterations
    assert rows_broken(exact.model, quick.x) < 1e-8


def test_a_deadline_in_the_past_returns_the_start_at_once():
    model, start, _ = planned(SCENES["unequal angles"])
    found = solve_ipopt(model, start, deadline=time.monotonic() - 1.0)
    assert (found.stopped, found.iterations) == (StopReason.OUT_OF_TIME, 0)
    assert np.array_equal(found.x[: model.size.stop], start[: model.size.stop])


def test_a_deadline_stops_the_solver(monkeypatch: pytest.MonkeyPatch):
    """A hundredth of what it takes to solve; the clock stands, so that this is left to IPOPT."""
    monkeypatch.setattr(clock, "now", lambda: 100.0)
    model, start, _ = planned(SCENES["hollow flank"], 60)
    found = solve_ipopt(model, start, deadline=100.002)
    assert (found.stopped, found.word) == (StopReason.OUT_OF_TIME, "Maximum_WallTime_Exceeded")


def test_words_that_the_table_does_not_know_mean_failed():
    assert ipopt.stop_reason("Solve_Succeeded") is StopReason.SOLVED
    assert ipopt.stop_reason("Infeasible_Problem_Detected") is StopReason.INFEASIBLE
    assert ipopt.stop_reason("Maximum_WallTime_Exceeded") is StopReason.OUT_OF_TIME
    for word in ("Invalid_Number_Detected", "Restoration_Failed", "Splendid", ""):
        assert ipopt.stop_reason(word) is StopReason.FAILED


def test_a_function_without_a_value_is_a_failure():
    import casadi

    x = casadi.MX.sym("x", 1)
    wide = np.array([np.inf])
    program = ipopt.SmoothProgram(x, casadi.sqrt(x - 5.0), x, -wide, wide, -wide, wide)
    found = ipopt.solve(program, ipopt.StartingPoint(np.zeros(1)))
    assert found.stopped is StopReason.FAILED
    assert found.word == "Invalid_Number_Detected"


def test_bounds_that_cross_leave_no_point():
    import casadi

    x, one = casadi.MX.sym("x", 1), np.ones(1)
    program = ipopt.SmoothProgram(x, x, x, one, -one, -one, one)
    assert ipopt.solve(program, ipopt.StartingPoint(one)).stopped is StopReason.INFEASIBLE


def test_the_solver_is_silent(capfd: pytest.CaptureFixture[str]):
    answer(SCENES["unequal angles"], 8)
    assert capfd.readouterr() == ("", "")


def test_what_growing_mends_for_less_than_is_allowed_gets_no_run_of_its_own():
    spec, growth, tighten = SCENES["both"], 2e-3, 1e-5
    full, short = (answer(spec, tighten=tighten, growth=g) for g in (0.0, growth))
    assert short.found.iterations < full.found.iterations
    laws, size = short.model.recover(short.found.x)
    grown = enlarge_until_feasible(recover_cam(short.model.problem, laws, size, keep_size=True))
    assert grown is not None
    assert short.prime < grown.value <= (1.0 + growth) * short.prime
    assert np.max(excess(spec, short.model, short.model.point(laws, grown.size))) <= 1e-7
    # and no more than asked for where that would not do
    least = answer(spec, tighten=tighten, growth=1e-9)
    assert least.found.iterations == full.found.iterations


@pytest.mark.parametrize("name", ["symmetric", "hollow flank"])
def test_a_cam_grows_no_farther_than_it_must(name: str):
    spec = SCENES[name]
    model, start, _ = planned(spec)
    laws, size = model.recover(start)
    assert np.max(excess(spec, model, start)) <= 1e-9
    smaller = (*size[:-1], 0.99 * size[-1])  # differences are taken inside the intervals alone
    assert np.max(excess(spec, model, model.point(laws, smaller))) > 0.0
