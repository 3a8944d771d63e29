"""The direct matrices against the same models stated in CVXPY: one optimum, two statements."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.catalogue.constraints import AffineNorm
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.problem.problem import ObjectiveCap
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.conic.reference import optimum
from tests.optimise.scenes import (
    PLAIN,
    TURNING,
    acceleration,
    angles,
    direct,
    dwell,
    even,
    fall,
    jerk,
    moved,
    problem,
    rise,
    scene,
    uneven,
    velocity,
)  # fmt: skip

SAME = 3e-6  # relative: what two solvers may differ by with C4 laws that overshoot
STEPS = (rise(61.3, 11.9), rise(77.9, 15.4), dwell(41.7), fall(99.1), dwell(80.0))
LIMITS = (angles(29.3, 41.7), velocity(2.13, 71.7), acceleration(6.3, 71.7), jerk(67.0, 71.7))

CASES: dict[str, DesignSpec] = {
    "size": scene(PLAIN, angles(29.3, 41.7), jerk(47.0, 71.7)),
    "size, every motion limit": scene(PLAIN, *LIMITS),
    "size, velocity": scene(PLAIN, angles(29.3, 41.7), velocity(1.61, 71.7)),
    "size, acceleration": scene(PLAIN, angles(21.0, 63.0), acceleration(5.1, 71.7)),
    "size, knife edge": scene(PLAIN, angles(29.3, 41.7), jerk(47.0, 71.7), roller=0.0),
    "size, no motion limit": scene(PLAIN, angles(29.3, 41.7)),
    "size, angle on dwells": scene(PLAIN, angles(31.0, 37.0, dwell_deg=17.3), jerk(47.0, 71.7)),
    "size, unequal angles": scene(PLAIN, angles(5.0, 70.0), jerk(47.0, 71.7)),
    "size, outer radius": scene(
        PLAIN, angles(33.0, 44.0), jerk(47.0, 71.7), {"kind": "outer_radius", "max_mm": 71.3}
    ),
    "size, fixed offset": scene(PLAIN, angles(29.3, 41.7), jerk(47.0, 71.7), offset=7.7),
    "size, offset to the wrong side": scene(PLAIN, angles(35.0, 35.0), offset=-6.1),
    "size, ranged offset": scene(
        PLAIN, angles(29.3, 41.7), jerk(47.0, 71.7), offset={"min": -3.0, "max": 4.9}
    ),
    "size, ranged base radius": scene(
        PLAIN, angles(29.3, 41.7), jerk(47.0, 71.7), base={"min": 11.0, "max": 55.7}
    ),
    "size, overshoot": scene(
        (rise(71.7, overshoot=True), dwell(23.9), fall(83.3), dwell(181.1)),
        angles(29.3, 41.7),
        velocity(3.0, 71.7),
        jerk(290.0, 71.7),
    ),
    "size, turning": scene(TURNING, angles(23.0, 33.0), jerk(51.0, 97.3)),
    "size, steps": scene(STEPS, angles(27.0, 36.0), jerk(63.0, 61.3, 15.4)),
    "size, named beside spline": scene(
        (rise(71.7, law="cycloidal"), fall(83.3), dwell(205.0)), angles(29.3, 41.7)
    ),
    "size, turning on a named law": scene(
        (rise(131.7, law="kloomok_muffley_8"), fall(97.3), dwell(131.0)), angles(23.0, 33.0)
    ),
    "size, rising from zero to high": scene(
        (fall(83.3), dwell(181.1), rise(71.7), dwell(23.9)), angles(29.3, 41.7), jerk(47.0, 71.7)
    ),
    "size, one degree": scene(
        (rise(1.0, 0.0131), dwell(40.0), fall(1.7, 0.0131), dwell(317.3)),
        angles(29.3, 41.7), jerk(41.0, 1.0, 0.0131),
    ),
    "peak acceleration": scene(PLAIN, jerk(61.0, 71.7), objective="peak_acceleration"),
    "peak acceleration at a size": scene(
        PLAIN, angles(29.3, 41.7), velocity(1.9, 71.7), base=37.3, offset=5.3,
        objective="peak_acceleration",
    ),
    "peak acceleration beside a named law": scene(
        (rise(71.7), dwell(23.9), fall(83.3, law="modified_sine"), dwell(181.1)),
        velocity(1.7, 71.7), objective="peak_acceleration",
    ),
    "peak jerk": scene(PLAIN, velocity(1.9, 71.7), objective="peak_jerk"),
    "peak jerk, turning": scene(TURNING, objective="peak_jerk"),
    "peak jerk at a size": scene(
        PLAIN, angles(29.3, 41.7), base=37.3, offset=5.3, objective="peak_jerk"
    ),
    "rms acceleration": scene(PLAIN, jerk(61.0, 71.7), objective="rms_acceleration"),
    "rms acceleration beside a named law": scene(
        (rise(71.7), dwell(23.9), fall(83.3, law="modified_sine"), dwell(181.1)),
        velocity(1.7, 71.7), objective="rms_acceleration",
    ),
    "rms jerk": scene(PLAIN, velocity(1.7, 71.7), objective="rms_jerk"),
    "rms jerk, turning, limited": scene(
        TURNING, acceleration(5.6, 97.3), objective="rms_jerk"
    ),
    "rms jerk at a size": scene(
        PLAIN, angles(29.3, 41.7), base=37.3, offset=5.3, objective="rms_jerk"
    ),
}  # fmt: skip


def agree(
    spec: DesignSpec, grids: list, level: float = 0.0, held: tuple[ObjectiveCap, ...] = ()
) -> float:
    question = problem(spec, held)
    found, expected = direct(question, grids, level), optimum(question, grids, level)
    assert expected.value is not None, expected.status
    assert found.value == pytest.approx(expected.value, rel=SAME)
    return found.value


@pytest.mark.parametrize("name", CASES)
def test_same_optimum(name: str) -> None:
    spec = CASES[name]
    agree(spec, even(problem(spec), 10))


@pytest.mark.parametrize("name", ["size", "size, turning", "peak jerk", "rms acceleration"])
@pytest.mark.parametrize("smoothness", [3, 4])
def test_smoother_laws(name: str, smoothness: int) -> None:
    body = CASES[name].model_dump()
    for segment in body["program"]:
        if segment["kind"] != "dwell":
            segment["law"]["smoothness"] = smoothness
    for limit in body["limits"]:
        if limit["kind"] == "jerk":
            limit["max_mm_per_s3"] *= 1.4
    spec = DesignSpec.model_validate(body)
    agree(spec, even(problem(spec), 12))


@pytest.mark.parametrize("name", ["rms jerk, turning, limited", "rms jerk at a size"])
@pytest.mark.parametrize("intervals", [48, 144])
def test_mean_squares_on_fine_knots(name: str, intervals: int) -> None:
    """Stated by the spline's squared matrix, they lost half of their digits here."""
    agree(CASES[name], even(problem(CASES[name]), intervals))


def test_laws_of_different_smoothness_share_what_both_have() -> None:
    program = (rise(131.7, smoothness=4), fall(97.3, smoothness=2), dwell(131.0))
    spec = scene(program, angles(23.0, 33.0), jerk(71.0, 97.3))
    agree(spec, even(problem(spec), 11))
    question = problem(spec)
    found = direct(question, even(question, 11))
    motion = moved(question, found.model.recover(found.solution.x)[0])
    joint = np.array([question.segments[0].end])
    left, right = (motion.derivatives(joint, 3, side)[:, 0] for side in ("left", "right"))
    assert left[:3] == pytest.approx(right[:3], rel=1e-9, abs=1e-7)
    assert abs(left[3] - right[3]) > 1.0  # free to jump: the return promises no more


@pytest.mark.parametrize("name", ["size, every motion limit", "size, turning", "rms jerk"])
@pytest.mark.parametrize("seed", [1, 2])
def test_uneven_knots(name: str, seed: int) -> None:
    spec = CASES[name]
    agree(spec, uneven(problem(spec), seed))


@pytest.mark.parametrize("level", [0.31, 0.77])
def test_fractional_objective_at_a_trial_level(level: float) -> None:
    spec = scene(
        PLAIN, jerk(47.0, 71.7), base={"max": 41.3}, offset={"max": 9.3},
        objective="peak_pressure_angle",
    )  # fmt: skip
    question = problem(spec)
    agree(spec, even(question, 10), level)


@pytest.mark.parametrize("first", ["base_radius", "peak_acceleration", "rms_jerk"])
@pytest.mark.parametrize("then", ["peak_jerk", "rms_acceleration", "base_radius"])
def test_objectives_held(first: str, then: str) -> None:
    if first == then:
        return
    limits = (angles(29.3, 41.7), jerk(61.0, 71.7))
    question = problem(scene(PLAIN, *limits, objective=first))
    grids = even(question, 9)
    best = direct(question, grids).value
    held = (ObjectiveCap(question.objective, best * 1.013),)
    looser = agree(scene(PLAIN, *limits, objective=then), grids, held=held)
    free = direct(problem(scene(PLAIN, *limits, objective=then)), grids).value
    assert looser >= free * (1.0 - 1e-8)


def test_a_held_pressure_angle() -> None:
    spec = scene(PLAIN, jerk(61.0, 71.7), base=33.7, objective="peak_pressure_angle")
    held = (ObjectiveCap(spec.objectives()[0], 0.55),)
    then = scene(PLAIN, jerk(61.0, 71.7), base=33.7, objective="rms_acceleration")
    tight = agree(then, even(problem(then), 9), held=held)
    assert tight > direct(problem(then), even(problem(then), 9)).value * 1.001


@pytest.mark.parametrize(
    "spec",
    [
        scene(PLAIN, jerk(31.0, 71.7), base={"min": 5.0}),
        scene(PLAIN, angles(9.0, 9.0), jerk(47.0, 71.7), base={"max": 30.0}),
        scene(PLAIN, velocity(1.5, 71.7), acceleration(4.5, 71.7), base={"min": 5.0}),
    ],
)
def test_both_find_nothing_where_nothing_is(spec: DesignSpec) -> None:
    question = problem(spec)
    grids = even(question, 10)
    assert solve(formulate(question, grids).program).stopped is StopReason.INFEASIBLE
    assert optimum(question, grids).value is None


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_unit_of_length_does_not_matter(size: float) -> None:
    limits = (angles(29.3, 41.7), jerk(47.0, 71.7))
    plain = problem(scene(PLAIN, *limits))
    body = scene(PLAIN, *limits).model_dump()
    for segment in body["program"]:
        if "lift_mm" in segment:
            segment["lift_mm"] *= size
    body["limits"][1]["max_mm_per_s3"] *= size
    scaled = problem(DesignSpec.model_validate(body))
    grids = even(plain, 10)
    assert direct(scaled, grids).value == pytest.approx(direct(plain, grids).value * size, rel=1e-8)


def test_mirroring_the_program_mirrors_the_offset() -> None:
    """Run backwards, a rise becomes a return: the offset changes sides, the radius stays."""
    limits = (angles(29.3, 41.7), jerk(47.0, 71.7))
    there = problem(scene(PLAIN, *limits))
    back = problem(scene((rise(83.3), dwell(23.9), fall(71.7), dwell(181.1)),
                         angles(41.7, 29.3), jerk(47.0, 71.7)))  # fmt: skip
    one, two = direct(there, even(there, 10)), direct(back, even(back, 10)[::-1])
    grids = even(there, 10)
    two = direct(back, [grids[1], grids[0]])
    assert two.value == pytest.approx(one.value, rel=1e-8)
    offsets = [d.model.recover(d.solution.x)[1][0] for d in (one, two)]
    assert offsets[0] == pytest.approx(-offsets[1], rel=1e-5)
    assert abs(offsets[0]) > 0.1


@st.composite
def scenes(draw: st.DrawFn) -> tuple[DesignSpec, int]:
    """Limits are multiples of what a good law needs; on few knots even that may be too little."""
    lift = draw(st.floats(0.5, 80.0))
    up, top, down = (draw(st.floats(a, 110.0)) for a in (25.0, 0.5, 25.0))
    free = {
        "smoothness": draw(st.sampled_from([2, 2, 3, 4])),
        "overshoot": draw(st.sampled_from([False, False, True])),
    }
    middle = [dwell(top)] if draw(st.booleans()) else []
    rest = 360.0 - up - down - sum(d["angle_deg"] for d in middle)
    program = (rise(up, lift, **free), *middle, fall(down, lift, **free), dwell(rest))
    fast = min(up, down)
    chosen = [
        velocity(draw(st.floats(2.0, 4.0)), fast, lift),
        acceleration(draw(st.floats(7.0, 15.0)), fast, lift),
        jerk(draw(st.floats(75.0, 300.0)), fast, lift),
    ]
    limits = [limit for limit in chosen if draw(st.booleans())]
    limits.append(angles(draw(st.floats(15.0, 55.0)), draw(st.floats(15.0, 55.0))))
    kinds = ["base_radius", "peak_acceleration", "peak_jerk", "rms_acceleration", "rms_jerk"]
    objective = draw(st.sampled_from(kinds))
    roller = draw(st.sampled_from([0.0, 0.3 * lift]))
    offset = draw(st.sampled_from([None, 0.13 * lift, {"min": -0.2 * lift, "max": 0.1 * lift}]))
    spec = scene(program, *limits, objective=objective, offset=offset, roller=roller)
    return spec, draw(st.integers(6, 12))


@settings(max_examples=7)
@given(scenes())
def test_random_scenes(drawn: tuple[DesignSpec, int]) -> None:
    spec, intervals = drawn
    question = problem(spec)
    for grids in (even(question, intervals), uneven(question, intervals)):
        if solve(formulate(question, grids).program).stopped is StopReason.INFEASIBLE:
            assert optimum(question, grids).value is None
        else:
            agree(spec, grids)


@given(st.integers(0, 10_000))
def test_no_size_in_its_box_has_a_norm_below_the_floor(seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix, shift = rng.uniform(-2.0, 2.0, (2, 2)), rng.uniform(-30.0, 30.0, 2)
    ends = np.sort(rng.uniform(-20.0, 20.0, (2, 2)), axis=1)
    norm = AffineNorm(tuple(map(tuple, matrix)), tuple(shift))
    z = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * rng.uniform(0.0, 1.0, (2, 200))
    nearest = min(norm.value(tuple(point)) for point in z.T)
    floor = norm.lower_bound([tuple(pair) for pair in ends])
    assert floor <= nearest
    along = AffineNorm(((1.0, 0.0), (0.0, -1.0)), tuple(shift))
    clipped = np.clip([-shift[0], shift[1]], ends[:, 0], ends[:, 1])
    assert along.lower_bound([tuple(pair) for pair in ends]) == pytest.approx(
        along.value(tuple(clipped))
    )
