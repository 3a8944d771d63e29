"""Half-planes of the size that every law keeps: closed forms, constructed cams, whole answers.

Constructed: laws of a family of the test's own (a Beta distribution's function, a sum of two, also
one that turns back) on random sizes. A limit on the pressure angle is what such a cam has itself,
by the instant centre, so that the cam is a point of the question, and no half-plane may cut it off.
"""

from __future__ import annotations

from fractions import Fraction
from math import cos, exp, expm1, hypot, inf, nextafter, pi, radians, sin, tan
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.stats import beta

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.fields import Range
from synthesis.numerics.piecewise import Array
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.relaxation import any_law
from synthesis.optimise.relaxation.any_law import (
    half_planes_of_free_laws,
    least_size,
    size_conflict,
)
from tests.optimise import arms
from tests.optimise.scenes import LIFT, OMEGA, angles, dwell, fall, problem, rise, scene

PROGRAM = (rise(41.3), dwell(29.9), fall(67.9), dwell(220.9))
LEVELS = np.linspace(0.0, 1.0, 4001)


def least_norm(question: Problem) -> float:
    size = least_size(question)
    assert size is not None
    return question.machine.follower.radius_norm().value(size)


# -- closed forms ----------------------------------------------------------------------------


def test_pressure_angle_of_a_centred_roller() -> None:
    # s' = t (s0 + s) all along the rise: s0 + h = s0 exp(t β)
    question = problem(scene(PROGRAM, angles(31.7, 37.3), offset=0))
    needed = [
        LIFT / (exp(tan(radians(a)) * radians(b)) - 1.0) for a, b in ((31.7, 41.3), (37.3, 67.9))
    ]
    assert least_norm(question) == pytest.approx(max(needed), rel=2e-6)
    assert least_norm(question) <= max(needed)


def test_velocity_and_pressure_angle_together() -> None:
    # as fast as the pressure angle allows, then as fast as the velocity does
    most = 1.21 * LIFT / radians(41.3)
    limits = angles(31.7, 89.0), {"kind": "velocity", "max_mm_per_s": most * OMEGA}
    slope = tan(radians(31.7))

    def excess(s0: float) -> float:
        corner = min(max(most / slope - s0, 0.0), LIFT)
        took = quad(lambda s: 1.0 / min(slope * (s0 + s), most), 0.0, LIFT, points=[corner])[0]
        return took - radians(41.3)

    question = problem(scene(PROGRAM, *limits, offset=0))
    assert least_norm(question) == pytest.approx(brentq(excess, 1.0, 1e4), rel=1e-5)


def test_offset_and_inner_half_planes() -> None:
    # the rise alone decides: s0 + e/t is bounded, and e ≤ t s0 where the follower rests
    question = problem(scene(PROGRAM, angles(31.7, 89.0)))
    slope = tan(radians(31.7))
    level = LIFT / (exp(slope * radians(41.3)) - 1.0)  # of s0 + e/t
    corner = 0.5 * level
    assert least_norm(question) == pytest.approx(hypot(corner, slope * corner), rel=2e-6)


@pytest.mark.parametrize("tilted", [False, True])
def test_radius_under_a_flat_face(tilted: bool) -> None:
    more = {"tilt_deg": 11.7, "offset_mm": -6.3} if tilted else {}
    spec = DesignSpec.model_validate({
        "speed_rpm": 83.7, "program": list(PROGRAM), "objective": {"kind": "base_radius"},
        "follower": {"kind": "translating_flat_face", **more},
        "limits": [{"kind": "profile_radius", "min_mm": 3.7}],
    })  # fmt: skip
    # s'' = −(s + Rb − ρ) up to the top of each move: cos β = A/(A + h), A = Rb − ρ
    needed = max(LIFT * cos(b) / (1.0 - cos(b)) for b in (radians(41.3), radians(67.9))) + 3.7
    if tilted:  # along the face's normal the lift is h cos τ
        needed = 3.7 + (needed - 3.7) * cos(radians(11.7))
    assert least_norm(problem(spec)) == pytest.approx(needed, rel=1e-6)


@pytest.mark.parametrize("sense", ["same", "opposite"])
def test_radius_under_a_face_that_swings(sense: str) -> None:
    # h + h'' = ρ in the normal's own angle, up to the top of each move: one equation of ψ0
    turning, top = {"same": -1.0, "opposite": 1.0}[sense], radians(SWING)

    def excess(start: float, angle: float, sign: float) -> float:
        turn = cos(radians(angle) + turning * sign * top)
        left = FACE_PIVOT * (sin(start) - turn * sin(start + top))
        return left - (3.7 + FACE_OFFSET) * (1.0 - turn)

    starts = [
        brentq(excess, 1e-6, 0.5 * pi - top, args=(angle, sign))
        for angle, sign in ((61.3, 1.0), (87.9, -1.0))
    ]
    needed = FACE_PIVOT * sin(max(starts)) - FACE_OFFSET
    assert least_norm(problem(swinging_face(3.7, sense))) == pytest.approx(needed, rel=1e-7)


# -- constructed cams ------------------------------------------------------------------------


def random_law(rng: np.random.Generator, *, turning: bool) -> tuple[Array, Array]:
    """g and g' of a law from 0 to 1 that rests at both ends."""
    weight, x = rng.uniform(0.2, 0.8), LEVELS
    parts = [(w, beta(*rng.uniform(1.6, 4.5, 2))) for w in (weight, 1.0 - weight)]
    g, speed = (sum(w * getattr(part, name)(x) for w, part in parts) for name in ("cdf", "pdf"))
    if turning:
        high, wave, flat = rng.uniform(0.2, 0.6), np.sin(2.0 * pi * x), x * (1.0 - x)
        g = g + high * wave * flat
        steep = 2.0 * pi * np.cos(2.0 * pi * x) * flat + wave * (1.0 - 2.0 * x)
        speed = speed + high * steep
    return np.asarray(g), np.asarray(speed)


def assert_kept(question: Problem, size: tuple[float, ...], rng: np.random.Generator) -> None:
    """No half-plane, about whatever size, cuts a size off that has a cam."""
    planes_about = half_planes_of_free_laws(question)
    count = 0
    for _ in range(6):
        about = np.array(size) * rng.uniform(0.4, 1.3, len(size))
        planes = planes_about(tuple(about))
        count += len(planes.offsets)
        assert np.max(planes.normals @ np.array(size) - planes.offsets) < 1e-6
    assert count > 6
    assert size_conflict(question) == ""
    assert least_norm(question) <= question.machine.follower.radius_norm().value(size) * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(14))
def test_a_cam_on_a_slide_keeps_all_half_planes(seed: int) -> None:
    rng = np.random.default_rng([71, seed])
    e, s0 = rng.uniform(-6.0, 6.0), rng.uniform(8.0, 60.0)
    found = list[float]()
    for angle, sign in ((41.3, 1.0), (67.9, -1.0)):
        g, speed = random_law(rng, turning=seed % 3 == 0)
        s = LIFT * (g if sign > 0 else 1.0 - g)
        found.append(np.max(np.abs(sign * LIFT * speed / radians(angle) - e) / (s0 + s)))
    limits = angles(*(float(np.degrees(np.arctan(x))) * (1 + 1e-6) for x in found))
    free = {"overshoot": True} if seed % 3 == 0 else {}
    program = (rise(41.3, **free), dwell(29.9), fall(67.9, **free), dwell(220.9))
    offset = {0: None, 1: e}[seed % 2]
    assert_kept(problem(scene(program, limits, offset=offset, roller=0.9)), (e, s0), rng)


@pytest.mark.parametrize("given", [False, True])
@pytest.mark.parametrize("sense", ["same", "opposite"])
@pytest.mark.parametrize("seed", range(4))
def test_a_cam_under_an_arm_keeps_all_half_planes(
    monkeypatch: pytest.MonkeyPatch, seed: int, sense: str, given: bool
) -> None:
    if seed > 1:  # on coarse cells what F bends up by counts
        monkeypatch.setattr(any_law, "CELLS", 2)
    rng = np.random.default_rng([73, seed])
    distance, start = arms.ARM * rng.uniform(0.9, 1.3), radians(rng.uniform(14.0, 70.0))
    swing, found = radians(arms.SWING), list[float]()
    for angle, sign in ((arms.RISE, 1.0), (arms.FALL, -1.0)):
        g, speed = random_law(rng, turning=False)
        psi = start + swing * (g if sign > 0 else 1.0 - g)
        rate = sign * swing * speed / radians(angle)
        found.append(np.max(np.abs(arms.slope(psi, rate, distance, sense))))
    limits = arms.angles(*(float(np.degrees(np.arctan(x))) * (1 + 1e-6) for x in found))
    spec = arms.scene(limits, distance=distance if given else None, sense=sense)
    spec = spec.model_copy(update={"objective": spec.objectives()[-1]})
    size = (arms.ARM * start,) if given else (distance * cos(start), distance * np.sin(start))
    assert_kept(problem(spec), tuple(map(float, size)), rng)


SWING, FACE_PIVOT, FACE_OFFSET = 13.7, 97.3, 2.9  # deg, mm, mm


def swinging_face(radius: float, sense: str, *, free: bool = False, **more: Any) -> DesignSpec:
    law = {"kind": "spline", "overshoot": True}
    move = {"lift_deg": SWING, "law": law}
    program = [
        {"kind": "rise", "angle_deg": 61.3, **move}, {"kind": "dwell", "angle_deg": 29.9},
        {"kind": "return", "angle_deg": 87.9, **move}, {"kind": "dwell", "angle_deg": 180.9},
    ]  # fmt: skip
    distance = {"min": 0.7 * FACE_PIVOT, "max": 1.3 * FACE_PIVOT} if free else FACE_PIVOT
    follower = {"kind": "oscillating_flat_face", "centre_distance_mm": distance,
                "face_offset_mm": FACE_OFFSET, "sense": sense}  # fmt: skip
    return DesignSpec.model_validate({
        "speed_rpm": 83.7, "program": program, "objective": {"kind": "base_radius"},
        "follower": follower, "limits": [{"kind": "profile_radius", "min_mm": radius}], **more,
    })  # fmt: skip


def random_swing(rng: np.random.Generator, *, turning: bool) -> tuple[Array, Array, Array]:
    """g, g' and g'' of a law from 0 to 1 whose second derivative is bounded."""
    x, weight = LEVELS[1:-1], rng.uniform(0.2, 0.8)
    g, speed, bend = (np.zeros_like(x) for _ in range(3))
    for share in (weight, 1.0 - weight):
        a, b = rng.uniform(2.1, 4.5, 2)
        density = share * beta(a, b).pdf(x)
        g, speed = g + share * beta(a, b).cdf(x), speed + density
        bend = bend + density * ((a - 1.0) / x - (b - 1.0) / (1.0 - x))
    if turning:
        k = 4.0 * pi
        g = g + 0.01 * (1.0 - np.cos(k * x))
        speed, bend = speed + 0.01 * k * np.sin(k * x), bend + 0.01 * k * k * np.cos(k * x)
    return g, speed, bend


def random_move(
    rng: np.random.Generator, start: float, sigma: float, move: tuple[float, float], turning: bool
) -> tuple[Array, Array, Array]:
    """Swing, its rate and the profile's radius along a move of a random law (angle, sign)."""
    (angle, sign), (g, speed, bend) = move, random_swing(rng, turning=turning)
    swing = radians(SWING) * (g if sign > 0 else 1.0 - g)
    rate = sign * radians(SWING) * speed / radians(angle)
    change = sign * radians(SWING) * bend / radians(angle) ** 2
    # the profile is the envelope of lines at h = d sinψ − f, whose normals turn by w = 1 + σψ'
    psi, w = start + swing, 1.0 + sigma * rate
    assert np.min(w) > 0.0
    slope = FACE_PIVOT * np.cos(psi) * rate / w  # dh/dχ
    further = FACE_PIVOT * (np.cos(psi) * change - np.sin(psi) * rate**2) / w
    radius = FACE_PIVOT * np.sin(psi) - FACE_OFFSET + (further - slope * sigma * change / w) / w
    return swing, rate, radius


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("sense", ["same", "opposite"])
@pytest.mark.parametrize("angle", [51.7, 143.0, 301.0])
def test_a_part_of_a_move_under_a_face_keeps_its_half_planes(
    angle: float, sense: str, free: bool
) -> None:
    # the ends move, at velocities that are known; and a part may be longer than half a turn
    rng, sigma = np.random.default_rng([83, int(angle)]), {"same": -1.0, "opposite": 1.0}[sense]
    nearest, count = inf, 0
    for sign in (1.0, -1.0, 1.0, -1.0):
        start = radians(rng.uniform(20.0, 70.0))
        swing, rate, radius = random_move(rng, start, sigma, (angle, sign), sign > 0.0)
        for first, last in np.sort(rng.integers(1, len(swing) - 1, (25, 2)), axis=1).tolist():
            if last - first < 80:
                continue
            least = float(np.min(radius[first : last + 1])) - 1e-4 * FACE_PIVOT
            face = swinging_face(1.0, sense, free=free).follower
            curve = face.profile_radius_constraints(least)[0]
            ends = [face.reference * np.array([swing[k], rate[k]]) for k in (first, last)]
            length = radians(angle) * (LEVELS[last] - LEVELS[first])
            p, base = FACE_PIVOT * cos(start), FACE_PIVOT * sin(start) - FACE_OFFSET
            size = np.array([p, base] if free else [base])
            planes = curve.half_planes_over_move(length, *ends)
            unknown = ends[0] * np.array([1.0, np.nan])
            known = curve.half_planes_over_move(length, unknown, ends[1])
            assert 2 * len(known) == len(planes)
            for plane in planes:
                nearest = min(nearest, float(np.min(plane.upper - size @ plane.size)))
                count += 1
    assert count > 80
    assert 0.0 <= nearest < 0.05 * FACE_PIVOT


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("sense", ["same", "opposite"])
@pytest.mark.parametrize("seed", range(3))
def test_a_cam_under_a_face_that_swings_keeps_all_half_planes(
    seed: int, sense: str, free: bool
) -> None:
    rng, sigma = np.random.default_rng([79, seed]), {"same": -1.0, "opposite": 1.0}[sense]
    start, least = 0.0, -inf
    while least < 0.0:  # most of these laws ask for a large cam
        start = radians(rng.uniform(50.0, 75.0))
        moves = ((61.3, 1.0), (87.9, -1.0))
        every = (random_move(rng, start, sigma, move, seed % 3 == 0) for move in moves)
        least = min(float(np.min(radius)) for _, _, radius in every)
    p, base = FACE_PIVOT * cos(start), FACE_PIVOT * sin(start) - FACE_OFFSET
    question = problem(swinging_face(least * (1.0 - 1e-7), sense, free=free))
    assert_kept(question, (p, base) if free else (base,), rng)


@pytest.mark.parametrize("sense", ["same", "opposite"])
@pytest.mark.parametrize("seed", range(4))
def test_a_least_distance_of_the_pivot_cuts_off_no_cam(seed: int, sense: str) -> None:
    # random laws on a pivot no nearer than is allowed: none is below the least size; which is that
    # of a given pivot as near as that, where the bound grows with the distance
    rng, sigma = np.random.default_rng([83, seed]), {"same": -1.0, "opposite": 1.0}[sense]
    start, least = 0.0, -inf
    while least < 0.0:
        start = radians(rng.uniform(50.0, 75.0))
        every = (random_move(rng, start, sigma, m, seed > 1) for m in ((61.3, 1.0), (87.9, -1.0)))
        least = min(float(np.min(radius)) for _, _, radius in every)
    given = swinging_face(least * (1.0 - 1e-7), sense)

    def at(distance: Any) -> DesignSpec:
        follower = given.follower.model_copy(update={"centre_distance_mm": distance})
        return given.model_copy(update={"follower": follower})

    nearest, farther = Range(min=FACE_PIVOT, max=1.3 * FACE_PIVOT), Range(max=1.3 * FACE_PIVOT)
    found = least_norm(problem(at(nearest)))
    assert found <= FACE_PIVOT * sin(start) - FACE_OFFSET
    assert found > 1.02 * least_norm(problem(at(farther)))
    distances = np.linspace(FACE_PIVOT, 1.3 * FACE_PIVOT, 7).tolist()
    each = [least_size(problem(at(distance))) for distance in distances]
    assert found == pytest.approx(min(size[-1] for size in each if size), rel=1e-6)


@pytest.mark.parametrize("given", [False, True])
def test_the_least_duration_is_bounded_from_below(
    monkeypatch: pytest.MonkeyPatch, given: bool
) -> None:
    # An arm that moves with the cam, where F bends up and 1/F down: a rise exactly as long as T
    # keeps its size, one a little shorter does not. On two cells the first holds for what F bends
    # up by alone. Laws may overshoot: nowhere is a velocity known.
    distance, start, limit = 41.7, radians(9.3), radians(7.1)

    def pace(psi: float) -> float:  # dθ/dψ where the pressure angle is at its limit
        return 1.0 / (1.0 - distance / arms.ARM * (cos(psi) - tan(limit) * sin(psi)))

    took = np.degrees(quad(pace, start, start + radians(arms.SWING))[0])
    exact = np.array(
        [arms.ARM * start] if given else [distance * cos(start), distance * sin(start)]
    )

    def excess(angle: float, cells: int) -> float:
        monkeypatch.setattr(any_law, "CELLS", cells)
        body = arms.body(
            arms.angles(float(np.degrees(limit)), 89.0), distance=distance if given else None,
            sense="same", objective={"kind": "base_radius"},
        )  # fmt: skip
        rise_, _, back, _ = body["program"]
        for move, length in ((rise_, angle), (back, 360.0 - angle)):
            move["angle_deg"], move["law"]["overshoot"] = length, True
        body["program"] = [rise_, back]
        planes = half_planes_of_free_laws(problem(DesignSpec.model_validate(body)))(tuple(exact))
        return float(np.max(planes.normals @ exact - planes.offsets, initial=-inf))

    assert excess(took * (1.0 + 1e-9), 2) <= 0.0
    assert excess(took * (1.0 - 1e-3), 200) > 1e-6


def test_the_mean_of_a_speed_that_is_quadratic_in_the_height_is_exact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of few cells T is Σ w/mean F, the mean by Simpson's rule; ∇T likewise of ∂F/∂z = 1 + s."""
    question, size, cells = problem(scene(PROGRAM, angles(31.7, 37.3))), np.zeros(2), 3
    a, b, c = 4.1, 0.37, 0.083

    def fastest(_: Any, __: Any, s: Array, *___: Any) -> list[tuple[Array, Array, float]]:
        return [(a + b * s + c * s**2, np.stack([1.0 + s, 0.0 * s]), 2.0 * c)]

    monkeypatch.setattr(any_law, "CELLS", cells)
    monkeypatch.setattr(any_law, "_fastest", fastest)
    edges = np.linspace(0.0, LIFT, cells + 1)
    middle, width = 0.5 * (edges[1:] + edges[:-1]), LIFT / cells
    ends, between = (fastest(0, 0, s)[0][0] for s in (edges, middle))
    mean = (ends[:-1] + 4.0 * between + ends[1:]) / 6.0
    duration, gradient = any_law._least_duration(question, question.free[0], size)
    assert duration == pytest.approx(np.sum(width / mean), rel=1e-12)
    assert duration < quad(lambda s: 1.0 / (a + b * s + c * s**2), 0.0, LIFT)[0]
    assert gradient[0] == pytest.approx(-np.sum(width * (1.0 + middle) / mean**2), rel=1e-12)


def test_rounding_of_large_offsets_cuts_no_cam_off() -> None:
    """T = log(1 + h/(s0 + e/t))/t, so that sizes far away whose terms cancel keep the limit."""
    question, rng = problem(scene(PROGRAM, angles(1.7, 89.0))), np.random.default_rng(3)
    segment, count = question.free[0], 0
    slope = -next(iter(question.limit_rows(segment))).size[1]
    assert slope == pytest.approx(tan(radians(1.7)))
    level = LIFT / expm1(slope * segment.angle) * (1.0 + 1e-12)  # of s0 + e/t, where T = β
    for _ in range(60):
        e = 1e9 * LIFT * rng.uniform(-1.0, 1.0)
        about = np.array([e, level * (1.0 - 10.0 ** rng.uniform(-6.0, -4.0)) - e / slope])
        e *= rng.uniform(0.5, 1.0)
        s0 = level - e / slope
        while Fraction(s0) + Fraction(e) / Fraction(slope) < Fraction(level):
            s0 = nextafter(s0, inf)
        for (normal,), (offset,), _ in any_law._half_plane(question, segment, about):
            count += 1
            beyond = sum(Fraction(n) * Fraction(z) for n, z in zip(normal, (e, s0), strict=True))
            assert beyond <= Fraction(offset)
    assert count > 30


# -- whole answers ---------------------------------------------------------------------------


def answer(**more: Any) -> Any:
    body = {
        "speed_rpm": 83.7, "program": list(PROGRAM), "limits": [angles(31.7, 37.3)],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 0.7, "offset_mm": 0},
        "time_budget_s": 4, **more,
    }  # fmt: skip
    return synthesise(DesignSpec.model_validate(body))


INFIMUM = LIFT / (exp(tan(radians(31.7)) * radians(41.3)) - 1.0) - 0.7  # of the base radius


def test_the_bound_holds_over_all_laws_where_nothing_is_capped() -> None:
    design = answer(objective={"kind": "base_radius"})
    certificate = design.certificate
    assert certificate.bound_valid_for.startswith("every motion law, whatever its derivatives")
    assert certificate.lower_bound == pytest.approx(INFIMUM, rel=1e-5)
    assert certificate.lower_bound <= INFIMUM <= certificate.value < 1.03 * INFIMUM


@pytest.mark.parametrize("objective", [None, {"kind": "base_radius"}])
def test_a_maximum_below_the_infimum_is_infeasible(objective: Any) -> None:
    design = answer(objective=objective, base_radius_mm={"max": 0.97 * INFIMUM}, time_budget_s=None)
    assert design.status == "infeasible"
    assert design.conflict.proven
    radius = next(x for x in design.conflict.relaxations if x.limit == "base_radius")
    assert 0.999 * INFIMUM < radius.at_least <= INFIMUM <= radius.needed


def test_a_maximum_above_the_infimum_has_a_cam() -> None:
    assert answer(base_radius_mm={"max": 1.04 * INFIMUM}).status in ("feasible", "optimal")


@pytest.mark.parametrize("sense", ["same", "opposite"])
def test_a_face_that_swings_under_too_small_a_maximum(sense: str) -> None:
    needed = least_norm(problem(swinging_face(3.7, sense)))
    small = swinging_face(3.7, sense, base_radius_mm={"max": 0.99 * needed})
    design = synthesise(small.model_copy(update={"objective": None, "time_budget_s": 4.0}))
    assert design.status == "infeasible"
    assert "no size fits" in design.conflict.evidence
    # no search is made for it: not a single program
    state = optimise(problem(small), 1e-3)
    assert "no size fits" in state.infeasibility_proof
    assert not state.stages
    wider = swinging_face(3.7, sense, base_radius_mm={"max": 1.01 * needed})
    assert not size_conflict(problem(wider))


def test_an_outer_radius_that_no_law_keeps() -> None:
    limits = angles(31.7, 37.3), {"kind": "outer_radius", "max_mm": INFIMUM + 0.97 * LIFT}
    assert "outer radius" in size_conflict(problem(scene(PROGRAM, *limits, offset=0, roller=0.7)))
    wider = limits[0], {"kind": "outer_radius", "max_mm": INFIMUM + 1.03 * LIFT}
    assert not size_conflict(problem(scene(PROGRAM, *wider, offset=0, roller=0.7)))


def test_an_arm_that_no_law_mends() -> None:
    # of a given pivot, the least duration of the rise falls and rises with ψ0, above the rise's all
    limits = arms.angles(35.0, 40.0)
    body = arms.body(limits, distance=98.9, objective={"kind": "base_radius"})
    body["program"][0] |= {"angle_deg": 46.1}
    body["program"][3]["angle_deg"] += arms.RISE - 46.1
    assert "no size fits" in size_conflict(problem(DesignSpec.model_validate(body)))
    body["limits"] = [arms.angles(39.0, 40.0)]
    assert not size_conflict(problem(DesignSpec.model_validate(body)))


def test_a_cap_does_not_keep_the_theorem_out() -> None:
    limits = [angles(31.7, 37.3), {"kind": "jerk", "max_mm_per_s3": 9e9}]
    design = answer(limits=limits, base_radius_mm={"max": 0.9 * INFIMUM}, time_budget_s=3)
    assert design.status == "infeasible"
