"""Thorough proofs of programs with many free laws: the better cams, the planes, and the work."""

from dataclasses import replace
from functools import cache
from math import inf, pi, radians

import numpy as np
import pytest
from scipy.optimize import linprog

from synthesis import DesignSpec
from synthesis.optimise.branching.node import BindingLimits, BoundTask
from synthesis.optimise.branching.traced_node import TracedNode, solve_relaxation
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.subprogram import coupled_laws, submodel
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.grid import Grid, uniform_grid
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.propagation import quantity_bounds as narrowing
from synthesis.optimise.propagation.bound_tightening import tighten_bounds
from synthesis.optimise.propagation.half_spaces import HalfSpaces, directions_around
from synthesis.optimise.propagation.improving_region import initial_region
from synthesis.optimise.propagation.law_tightening import with_value_cap
from synthesis.optimise.state import QUICK, THOROUGH

OMEGA, SHARES = 10.0, (1.03, 0.91, 0.97, 1.12, 0.88, 1.06, 1.1, 0.93)


def program(laws: int, *, dwells: bool) -> DesignSpec:
    """Rises and returns under one jerk limit, with lifts that fit their angles."""
    moving = 251.0 if dwells else 360.0
    angles = moving * np.array(SHARES[:laws]) / sum(SHARES[:laws])
    segments, caps = [], []
    for k, angle in enumerate(angles):
        narrow = min(angles[k - k % 2 : k - k % 2 + 2])
        lift = 29.3 * (narrow / 60.0) ** 2 * (1.07 if k % 4 < 2 else 0.94)
        caps.append(32.0 * lift / radians(narrow) ** 3)
        kind = ("rise", "return")[k % 2]
        segments.append({"kind": kind, "angle_deg": angle, "lift_mm": lift})
        if dwells:
            segments.append({"kind": "dwell", "angle_deg": (360.0 - moving) / laws})
    return DesignSpec.model_validate(
        {
            "speed_rpm": OMEGA * 30.0 / pi,
            "program": segments,
            "follower": {"kind": "translating_roller", "roller_radius_mm": 9.7},
            "limits": [
                {"kind": "pressure_angle", "rise_deg": 31.0, "return_deg": 44.0},
                {"kind": "jerk", "max_mm_per_s3": 1.5 * max(caps) * OMEGA**3},
                {"kind": "profile_radius", "min_mm": 11.9},
            ],
            "tolerance": 5e-3,
        }
    )


@cache
def posed(laws: int, *, dwells: bool):
    """The question, and how far the ladder comes with it."""
    spec = program(laws, dwells=dwells)
    return optimise(formulate_problem(spec, spec.objectives()[0]), 5e-3)


def lair_of(found):
    """What is to be shown, and the lair of which nothing is known yet."""
    parts = BindingLimits.on((found.incumbent, found.relaxed)).parts
    task = BoundTask.of(found, found.incumbent, inf)
    parts = {k: each for k, each in parts.items() if each}
    return task, initial_region(task.problem, task.controls, parts)


def plan_of(task, intervals: int):
    problem = with_value_cap(task.problem, task.incumbent.value * (1 + 1e-9))
    spaces = (uniform_grid(s, intervals).space for s in problem.free)
    return formulate(problem, tuple(Grid(space, space.breaks) for space in spaces))


@pytest.fixture(scope="module", params=[True, False], ids=["dwells between", "no dwells"])
def found(request):
    return posed(6, dwells=request.param)


def test_the_best_cam_lies_where_better_cams_are_said_to_lie(found):
    task, domain = lair_of(found)
    model, best = plan_of(task, 30), found.incumbent
    for _ in range(2):  # the second time with rows of curvature, the first one's planes known
        domain, stuck = tighten_bounds(model, task.controls, domain, range(6))
        assert not stuck
        for (low, high), value in zip(domain.sizes, best.size, strict=True):
            assert low <= value <= high
        assert np.all(
            domain.half_spaces.normals @ np.array(best.size) >= domain.half_spaces.offsets
        )
        for (position, seen), hull in domain.point_bounds.items():
            law, segment = best.laws[position].curve(), found.problem.free[position]
            x = hull.nodes
            s = segment.s_start + segment.lift * law(x), segment.lift / segment.angle * law(x, 1)
            at = np.stack(seen.evaluate(s, best.size)[:2])
            assert np.all(hull.low - 1e-7 <= at)
            assert np.all(at <= hull.high + 1e-7)
        node = solve_relaxation(found, TracedNode(task, domain, lower=found.lower))
        domain = replace(domain, reference=node.region.reference)
    assert all(high - low < 25.0 for low, high in domain.sizes)


def test_a_proof_of_many_laws_comes_to_its_end():
    quick = posed(6, dwells=False)
    thorough = optimise(quick.problem, 1e-2, proof=THOROUGH)
    assert quick.gap_between(quick.incumbent, quick.lower) > 0.05
    assert thorough.gap_between(thorough.incumbent, thorough.lower) <= 1e-2
    assert thorough.lower <= quick.incumbent.value


def test_where_the_size_is_given_hulls_are_narrowed_and_no_box_is_cut():
    body = program(4, dwells=True).model_dump(exclude_none=True, exclude_unset=True)
    body["follower"]["offset_mm"] = 7.24
    body |= {"base_radius_mm": 33.26, "objective": {"kind": "peak_acceleration"}}
    spec = DesignSpec.model_validate(body)
    quick, thorough = (
        optimise(formulate_problem(spec, spec.objectives()[0]), 2e-2, proof=proof)
        for proof in (QUICK, THOROUGH)
    )
    assert thorough.incumbent is not None
    assert quick.lower < thorough.lower <= thorough.incumbent.value
    assert thorough.stages[-1].model.endswith("1 boxes")
    assert (
        thorough.gap_between(thorough.incumbent, thorough.lower) < 0.02
    )  # 0.025 without finer knots in the end


def test_the_work_grows_with_the_laws_and_not_with_their_square(monkeypatch):
    """Entries of the linear programs, times the quantities that are bounded under them."""
    work, own = list[int](), narrowing.highs.minimise_each

    def counted(rows, objectives, limit, enough):
        work.append(rows.matrix.nnz * len(objectives))
        return own(rows, objectives, limit, enough=enough)

    totals = []
    for laws in (4, 8):
        task, _ = lair_of(posed(laws, dwells=True))
        domain = initial_region(
            task.problem, task.controls, dict.fromkeys(range(laws), ((0.1, 0.9),))
        )
        monkeypatch.setattr(narrowing.highs, "minimise_each", counted)
        work.clear()
        tighten_bounds(plan_of(task, 20), task.controls, domain, range(laws))
        monkeypatch.undo()
        totals.append(sum(work))
    assert totals[1] < 2.3 * totals[0]


def test_a_part_has_the_rows_of_its_laws_and_of_the_size(found):
    task, _ = lair_of(found)
    model = plan_of(task, 20)
    positions = coupled_laws(model, 2)
    part = submodel(model, positions)
    assert positions == ((2,) if not model.junctions else (1, 2, 3))
    x = np.random.default_rng(4).normal(size=model.program.matrix.shape[1])
    inner = np.concatenate([*(x[model.columns[k]] for k in positions), x[model.size]])
    all_of_them, own = (
        p.program.rhs - p.program.matrix @ v for p, v in ((model, x), (part, inner))
    )
    assert part.program.inequalities + part.program.equalities == len(own)
    for slack in own:
        assert np.min(np.abs(all_of_them - slack)) < 1e-12


@pytest.mark.parametrize("seed", range(8))
def test_planes_bound_what_a_linear_program_says(seed):
    draw = np.random.default_rng(seed)
    box = ((-31.0, 17.0), (22.0, 61.0))
    inside = np.array([draw.uniform(a, b) for a, b in box])
    normals = draw.normal(size=(9, 2))
    floors = normals @ inside - draw.exponential(3.0, 9)
    directions = directions_around(box)
    found = HalfSpaces(normals, floors).minimise(directions, box)
    for direction, value in zip(directions, found, strict=True):
        true = linprog(direction, A_ub=-normals, b_ub=-floors, bounds=box).fun
        assert value <= true + 1e-12
        assert value == pytest.approx(true, abs=1e-6)


def test_planes_that_leave_no_size_say_so():
    planes = HalfSpaces(np.array([[1.0, 0.3], [-1.0, -0.3]]), np.array([11.0, -10.9]))
    assert np.all(planes.minimise(np.eye(2), ((0.0, 20.0), (0.0, 30.0))) == np.inf)
    touching = HalfSpaces(planes.normals, np.array([11.0, -11.0]))
    assert np.all(np.isfinite(touching.minimise(np.eye(2), ((0.0, 20.0), (0.0, 30.0)))))
