"""Arms sized: against a global search, against another nonlinear program, and over scales."""

from __future__ import annotations

from functools import cache
from math import cos, pi, radians, sqrt, tan
from typing import Any

import casadi
import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from tests.hard.families import random_scene
from tests.optimise.arms import (
    ARM,
    FALL,
    OMEGA,
    RISE,
    SENSES,
    SWING,
    angles,
    body,
    jerk,
    least,
    scene,
    slope,
)

DISTANCE = 101.9
LIMITS = tan(radians(38.3)), tan(radians(44.1))


def prime(design: Design) -> float:
    return design.dimensions["prime_radius_mm"]


def certified(design: Design) -> bool:
    return design.certificate.certified and all(extreme.holds for extreme in design.extremes)


# -- laws given ------------------------------------------------------------------------------


@cache
def dense(count: int) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """φ and φ' (count, 1) of the cycloidal rise and return, with tan of their limits."""
    x = np.linspace(0.0, 1.0, count)[:, None]
    g, rate = x - np.sin(2.0 * pi * x) / (2.0 * pi), 1.0 - np.cos(2.0 * pi * x)
    swing = radians(SWING)
    return [
        (swing * g, swing / radians(RISE) * rate, LIMITS[0]),
        (swing * (1.0 - g), -swing / radians(FALL) * rate, LIMITS[1]),
    ]


def prime_radius(
    arm: Any, start: np.ndarray, distance: Any, sense: str, count: int
) -> np.ndarray:  # fmt: skip
    """Prime radii [mm] of pivots, (k,); more than 1e4 where the pressure angle is too large."""
    worst = np.max(
        [
            np.max(np.abs(slope(start + phi, rate, distance, sense, arm)), axis=0) - limit
            for phi, rate, limit in dense(count)
        ],
        axis=0,
    )
    found = np.sqrt(distance**2 + arm**2 - 2.0 * distance * arm * np.cos(start))
    return np.where(worst <= 0.0, found, 1e4 + worst)


def searched(sense: str, distance: float | None) -> float:
    """The least prime radius by differential evolution over d and ψ0."""

    def radius(points: np.ndarray, count: int) -> np.ndarray:
        at = points[1] if distance is None else distance
        return prime_radius(ARM, points[0], at, sense, count)

    bounds = [(0.01, 2.5), (0.4 * ARM, 2.5 * ARM)][: 1 if distance is not None else 2]
    return least(radius, bounds)


@pytest.mark.parametrize(("sense", "distance"), [("opposite", None), ("same", DISTANCE)])
def test_given_law_as_small_as_a_global_search_finds(sense: str, distance: float | None) -> None:
    design = synthesise(scene(angles(), law="cycloidal", sense=sense, distance=distance))
    assert design.status == "optimal"
    assert certified(design)
    assert prime(design) == pytest.approx(searched(sense, distance), rel=1e-6)
    assert design.certificate.value == pytest.approx(design.dimensions["base_radius_mm"], rel=1e-9)
    assert design.certificate.bound_valid_for == "every size of the given laws"


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize(
    ("sense", "end", "factor"), [("opposite", "max", 0.93), ("same", "min", 1.1)]
)
def test_centre_distance_at_the_end_of_its_range(sense: str, end: str, factor: float) -> None:
    """Where the free answer lies outside, the best is at the end: as with that distance given."""
    free = synthesise(scene(angles(), law="cycloidal", sense=sense)).dimensions
    at = factor * free["centre_distance_mm"]
    ranged = synthesise(scene(angles(), law="cycloidal", sense=sense, distance={end: at}))
    given = synthesise(scene(angles(), law="cycloidal", sense=sense, distance=at))
    assert certified(ranged) == certified(given)
    if certified(given):
        assert ranged.dimensions["centre_distance_mm"] == pytest.approx(at, rel=1e-3)
        assert prime(ranged) == pytest.approx(prime(given), rel=1e-4)


# -- laws free, centre distance given -----------------------------------------------------------


def another_program(sense: str, distance: float, pieces: int, start: float) -> float:
    """The least prime radius with piecewise constant jerks as unknowns, by IPOPT.

    Returns:
        Rp [mm] of a law of |φ'''| ≤ the cap whose pressure angle is kept at many angles.
    """
    sigma, cap = SENSES[sense], 1.9 * 32.0  # of g''' on the rise
    psi0 = casadi.SX.sym("psi0")
    unknowns, rows, lower, upper, first = [psi0], [], [], [], [start]
    swing, ratio = radians(SWING), (FALL / RISE) ** 3
    courses = ((RISE, 1.0, LIMITS[0], 1.0), (FALL, -1.0, LIMITS[1], ratio))
    for angle, direction, limit, more in courses:
        j = casadi.SX.sym("j", pieces)
        width, g, v, a = 1.0 / pieces, 0.0, 0.0, 0.0
        for k in range(pieces):
            for share in (1.0 / 3.0, 2.0 / 3.0, 1.0):
                h = share * width
                at = g + v * h + a * h**2 / 2 + j[k] * h**3 / 6
                speed = v + a * h + j[k] * h**2 / 2
                phi = swing * (at if direction > 0 else 1.0 - at)
                away = distance / (1.0 + sigma * direction * swing / radians(angle) * speed)
                psi = psi0 + phi
                lean, reach = ARM - away * casadi.cos(psi), limit * away * casadi.sin(psi)
                rows += [(lean - reach) / ARM, (-lean - reach) / ARM, -speed]
                lower += [-casadi.inf] * 3
                upper += [0.0] * 3
            g, v, a = at, speed, a + j[k] * width
        rows += [g - 1.0, v, a]
        lower += [0.0] * 3
        upper += [0.0] * 3
        unknowns.append(j / (cap * more))
        first += [0.9, *[0.0] * (pieces // 2 - 1), *[-0.2] * (pieces - pieces // 2)]
        unknowns[-1] = j
    x = casadi.vertcat(*unknowns)
    caps = np.concatenate([np.full(pieces, cap), np.full(pieces, cap * ratio)])
    program = {"x": x, "f": psi0, "g": casadi.vertcat(*rows)}
    solver = casadi.nlpsol(
        "other", "ipopt", program,
        {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.max_iter": 500},
    )  # fmt: skip
    found = solver(
        x0=first, lbg=lower, ubg=upper,
        lbx=[0.01, *(-caps)], ubx=[2.5, *caps],
    )  # fmt: skip
    assert solver.stats()["success"]
    psi = float(found["x"][0])
    return sqrt(distance**2 + ARM**2 - 2.0 * distance * ARM * cos(psi))


@pytest.mark.parametrize(
    ("distance", "sense", "starts"), [(DISTANCE, "same", (0.4,)), (131.3, "opposite", (0.4, 1.1))]
)
def test_free_law_proven_and_as_small_as_another_program_finds(
    sense: str, distance: float, starts: tuple[float, ...]
) -> None:
    design = synthesise(scene(angles(), jerk(1.9), distance=distance, sense=sense, tolerance=5e-3))
    assert design.status == "optimal"
    assert certified(design)
    assert design.certificate.bound_valid_for == "all motion laws with a bounded jerk"
    assert design.certificate.gap is not None
    assert design.certificate.gap <= 5e-3
    assert design.certificate.lower_bound is not None
    lower = design.certificate.lower_bound + design.spec.follower.roller_radius_mm
    others = [another_program(sense, distance, 40, start) for start in starts]
    # its rows hold at 120 points only, which makes 4e-4; with three times as many it is 4e-5
    assert min(others) >= lower * (1.0 - 5e-4)
    assert min(others) == pytest.approx(prime(design), rel=6e-3)


@cache
def sized(law: str, by: float = 1.0) -> Design:
    limits = (angles(), jerk(1.9)) if law == "spline" else (angles(),)
    return synthesise(scene(*limits, distance=DISTANCE * by, law=law, scale=by, tolerance=1e-2))


def test_jerk_binds_in_degrees_per_second_cubed() -> None:
    limit = jerk(1.9)
    design = sized("spline")
    (extreme,) = [e for e in design.extremes if e.limit == "jerk"]
    assert extreme.unit == "deg/s³"
    assert abs(extreme.value or 0.0) == pytest.approx(limit["max_deg_per_s3"], rel=1e-6)
    # and by differences of the swing itself
    step = 1e-3
    theta = np.arange(0.05, radians(RISE) - 0.05, step)
    swing = design.curve.derivatives(theta, 0)[0] / ARM * 180.0 / pi
    third = np.abs(np.diff(swing, 3)) / step**3 * OMEGA**3
    # steps across a switch average what lies on both sides of it
    assert 0.9 * limit["max_deg_per_s3"] <= np.max(third) <= 1.0001 * limit["max_deg_per_s3"]


def test_profile_radius_costs_and_is_kept() -> None:
    least = {"kind": "profile_radius", "min_mm": 24.0}
    free = synthesise(scene(angles(), jerk(1.9), distance=131.3, tolerance=5e-3))
    held = synthesise(scene(angles(), jerk(1.9), least, distance=131.3, tolerance=5e-3))
    assert certified(held)
    assert prime(held) >= prime(free) * (1.0 - 5e-3)
    (extreme,) = [e for e in held.extremes if e.limit == "profile_radius"]
    assert extreme.value is not None
    assert extreme.value >= 24.0 - 1e-6


# -- all free -----------------------------------------------------------------------------------


def test_everything_free_is_proven_over_all_laws_and_pivots() -> None:
    """No cam of another program, whatever the pivot, is below the bound."""
    design = synthesise(scene(angles(), jerk(1.9), tolerance=5e-3))
    assert certified(design)
    assert design.status == "optimal"
    assert design.certificate.bound_valid_for == "all motion laws with a bounded jerk"
    assert design.certificate.gap is not None
    assert 0.0 < design.certificate.gap <= 5e-3
    assert design.certificate.lower_bound is not None
    lower = design.certificate.lower_bound + 7.9
    at = design.dimensions["centre_distance_mm"]
    others = [another_program("opposite", share * at, 40, 0.4) for share in (1.0, 1.015)]
    # its rows hold at 120 points only, which makes 4e-4
    assert min(others) >= lower * (1.0 - 5e-4)
    assert min(others) == pytest.approx(prime(design), rel=6e-3)


def test_a_least_centre_distance_that_binds_is_in_the_bound() -> None:
    far = 100.0
    limits = (angles(), jerk(1.9))
    free = synthesise(scene(*limits, distance={"min": far}, sense="opposite", tolerance=2e-2))
    given = synthesise(scene(*limits, distance=far, tolerance=2e-2))
    assert certified(free)
    assert free.dimensions["centre_distance_mm"] == pytest.approx(far, rel=1e-3)
    assert free.certificate.gap is not None
    assert free.certificate.gap <= 2e-2
    assert prime(free) == pytest.approx(prime(given), rel=5e-3)


# -- scales, senses, refusals ---------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-3, 1e3])
@pytest.mark.parametrize("law", ["cycloidal", "spline"])
def test_scale_changes_nothing_relative(scale: float, law: str) -> None:
    one, other = sized(law), sized(law, scale)
    assert certified(other)
    assert prime(other) / scale == pytest.approx(prime(one), rel=1e-6)


def test_the_cams_sense_of_rotation_changes_no_size() -> None:
    one = synthesise(scene(angles(), law="cycloidal", distance=DISTANCE))
    other = synthesise(scene(angles(), law="cycloidal", distance=DISTANCE, rotation="cw"))
    assert other.dimensions == one.dimensions


def test_other_objectives_see_the_limit_too() -> None:
    """Least jerk at a given base radius: more of it than without the pressure angle."""
    radius = sized("spline").dimensions["base_radius_mm"] * 1.1
    question: dict[str, Any] = {
        "distance": DISTANCE, "base_radius_mm": radius, "objective": {"kind": "peak_jerk"},
        "tolerance": 2e-2, "proof": "quick",
    }  # fmt: skip
    held, free = synthesise(scene(angles(), **question)), synthesise(scene(**question))
    assert certified(held)
    name = "peak_jerk_deg_per_s3"
    assert held.objectives[name] > 1.01 * free.objectives[name]
    assert held.objectives[name] < jerk(1.9)["max_deg_per_s3"] * 1.001


# the question, limits that are reported, and the field that it is explained by, if not by all
INFEASIBLE: dict[str, tuple[dict[str, Any], set[str], str]] = {
    "arm too long for the distance": (
        {"distance": 80.0, "law": "cycloidal", "tolerance": 0.05}, {"centre_distance"},
        "follower/centre_distance_mm",
    ),
    "base radius too small": (
        {"distance": DISTANCE, "law": "cycloidal", "base_radius_mm": {"max": 15.2}},
        {"base_radius", "pressure_angle_return"}, "",
    ),
    "jerk below the least": (
        {"distance": DISTANCE, "limits": (angles(), jerk(0.97))}, {"jerk"},
        "limits/1/max_deg_per_s3",
    ),
}  # fmt: skip


@pytest.mark.usefixtures("coarse_conflicts")
def test_a_given_law_that_breaks_a_limit_by_itself_is_named() -> None:
    question = body(angles(), jerk(1.9), distance=DISTANCE, law="cycloidal")
    question["program"][0]["law"] = {"kind": "modified_sine"}  # 69.47 h/β³, more than 1.9 · 32
    design = synthesise(DesignSpec.model_validate(question))
    assert design.status == "infeasible"
    assert design.conflict is not None
    (reported,) = design.conflict.relaxations
    assert reported.limit == "jerk"
    assert reported.needed == pytest.approx(jerk(69.4664 / 32.0)["max_deg_per_s3"], rel=2e-4)


@pytest.mark.usefixtures("coarse_conflicts")
@pytest.mark.parametrize("name", INFEASIBLE)
def test_infeasible_with_a_reason(
    name: str, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    question, named, field = INFEASIBLE[name]
    if field:
        request.getfixturevalue("explain_only")(field)
        monkeypatch.setattr("synthesis.pipeline.conflict.ACCURACIES", (0.2,))  # of the way
    limits = question.pop("limits", (angles(),))
    design = synthesise(scene(*limits, **question))
    assert design.status == "infeasible"
    assert design.conflict is not None
    reported = {relaxation.limit for relaxation in design.conflict.relaxations}
    assert named <= reported
    for relaxation in design.conflict.relaxations:
        if relaxation.needed is None or relaxation.limit not in ("jerk", "pressure_angle_return"):
            continue
        # the value told is one with which there is a cam
        eased = body(*limits, **question)
        _, position, field = relaxation.field.split("/")
        eased["limits"][int(position)][field] = relaxation.needed * (1.0 + 1e-4)
        eased["tolerance"] = 0.05
        assert synthesise(DesignSpec.model_validate(eased)).status != "infeasible"


@pytest.mark.parametrize("low", [91.2, 91.59])
def test_a_narrow_range_of_centre_distances_is_no_worse_than_its_end(low: float) -> None:
    """There the local searches end at cams that are half as large again as that of the end."""
    body = {**random_scene("arm, pivot given", 602), "proof": "quick"}
    follower = body["follower"]
    assert follower["centre_distance_mm"] == 91.6
    ranged = {**body, "follower": {**follower, "centre_distance_mm": {"min": low, "max": 91.6}}}
    wide, given = (synthesise(DesignSpec.model_validate(each)) for each in (ranged, body))
    assert certified(wide)
    assert certified(given)
    assert prime(wide) <= prime(given) * (1.0 + 1e-4)
