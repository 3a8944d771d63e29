"""A flat face on a pivot from spec to certificate: other solvers, other methods, refusals."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import casadi
import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import differential_evolution, linprog

from synthesis.catalogue.followers.swinging_face import LeastPivotDistance
from synthesis.catalogue.motion import Motion
from synthesis.design.design import Design
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS
from synthesis.pipeline.synthesise import synthesise
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.analyse import analyse
from tests.exporters.written import written
from tests.pipeline.test_flat_face import extreme

SWING, OFFSET, RPM = 9.7, 3.7, 83.7
RADIUS: dict[str, Any] = {"kind": "profile_radius", "min_mm": 4.1}
PRESSURE: dict[str, Any] = {"kind": "pressure_angle", "rise_deg": 8.0, "return_deg": 11.0}
FACE: dict[str, Any] = {"kind": "face_width", "near_mm": 20.0, "far_mm": 50.0}
JERK: dict[str, Any] = {
    "kind": "jerk",
    "max_deg_per_s3": 51.2 * SWING / math.radians(81.0) ** 3 * (RPM * math.pi / 30.0) ** 3,
}
FREE = {"max": 150.0}


def question(
    distance: Any, *limits: dict[str, Any], sense: str = "opposite", law: str = "cycloidal",
    swing: float = SWING, offset: float = OFFSET, **more: Any,
) -> DesignSpec:  # fmt: skip
    move = {"lift_deg": swing, "law": {"kind": law}}
    return DesignSpec.model_validate(
        {
            "speed_rpm": RPM,
            "program": [
                {"kind": "rise", "angle_deg": 81.0, **move},
                {"kind": "dwell", "angle_deg": 33.0},
                {"kind": "return", "angle_deg": 97.0, **move},
                {"kind": "dwell", "angle_deg": 149.0},
            ],
            "follower": {
                "kind": "oscillating_flat_face", "centre_distance_mm": distance,
                "face_offset_mm": offset, "sense": sense,
            },
            "limits": list(limits), "proof": "quick",
            **more,
        }
    )  # fmt: skip


def dense(spec: DesignSpec, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cam angle (n,), φ to φ'' (3, n) and the sign of the motion (n,) on all moves and dwells."""
    found = []
    for segment in spec.placed_segments():
        curve = segment.placed()
        step = np.linspace(1e-12, 1.0 - 1e-12, count)
        theta = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * step).ravel()
        sign = {"rise": 1.0, "return": -1.0, "dwell": 0.0}[segment.kind]
        motion = Motion.of(spec.placed_segments()).derivatives(theta, 2)
        largest = spec.follower.model_dump()["centre_distance_mm"]
        unit = largest["max"] if isinstance(largest, dict) else largest
        found.append((theta, motion / unit, np.full(len(theta), sign)))
    theta, phi, sign = zip(*found, strict=True)
    return np.concatenate(theta), np.concatenate(phi, axis=1), np.concatenate(sign)


def rows(spec: DesignSpec, count: int = 1501) -> tuple[np.ndarray, np.ndarray]:
    """All limits of the scenes here as table @ (p, q) ≤ rhs: divided, not multiplied, by w."""
    _, (phi, v, a), sign = dense(spec, count)
    follower = spec.follower.model_dump()
    sigma = {"opposite": 1.0, "same": -1.0}[follower["sense"]]
    f, w = follower["face_offset_mm"], 1.0 + sigma * v
    cos, sin = np.cos(phi), np.sin(phi)
    along, across = np.stack([cos, -sin], 1), np.stack([sin, cos], 1)  # d cosψ, d sinψ
    reach = along / w[:, None]
    named = {limit.kind: limit.model_dump() for limit in spec.limits}
    bend = across * (1.0 - v**2 / w**2)[:, None] + along * (a / w**3)[:, None]
    table, rhs = [-bend, -along], [np.full(len(w), -f - named["profile_radius"]["min_mm"]), 0.0 * w]
    if "pressure_angle" in named:
        for side, field in ((1.0, "rise_deg"), (-1.0, "return_deg")):
            least = f / math.tan(math.radians(named["pressure_angle"][field]))
            table.append(-reach[sign == side])
            rhs.append(np.full(np.count_nonzero(sign == side), -least))
    if "face_width" in named:
        table += [-reach, reach]
        rhs += [0.0 * w - named["face_width"]["near_mm"], 0.0 * w + named["face_width"]["far_mm"]]
    return np.concatenate(table), np.concatenate(rhs)


@cache
def free_distance(sense: str) -> tuple[DesignSpec, Design]:
    spec = question(FREE, RADIUS, PRESSURE, FACE, sense=sense)
    return spec, synthesise(spec)


@pytest.mark.parametrize("sense", ["opposite", "same"])
def test_with_the_distance_free_it_is_the_linear_program_of_dense_angles(sense: str) -> None:
    spec, design = free_distance(sense)
    table, rhs = rows(spec)
    kept = np.arange(0, len(rhs), 97)
    for _ in range(20):  # HiGHS is asked with those rows only that it would break
        found = linprog(
            [0.0, 1.0], table[kept], rhs[kept], bounds=[(0.0, None), (OFFSET, None)],
            method="highs", options={"primal_feasibility_tolerance": 1e-10},
        )  # fmt: skip
        excess = table @ found.x - rhs
        if np.max(excess) <= 1e-9:
            break
        kept = np.union1d(kept, np.argsort(excess)[-40:])
    assert np.max(table @ found.x - rhs) <= 1e-9
    assert design.status == "optimal"
    assert [stage.stage for stage in design.report.stages] == ["closed form"]
    assert design.dimensions["base_radius_mm"] == pytest.approx(found.x[1] - OFFSET, rel=1e-6)
    assert design.dimensions["centre_distance_mm"] == pytest.approx(math.hypot(*found.x), rel=1e-5)


@pytest.mark.parametrize("sense", ["opposite", "same"])
def test_with_the_distance_free_a_blind_search_finds_the_same(sense: str) -> None:
    spec, design = free_distance(sense)
    table, rhs = rows(spec, 601)

    def worth(z: np.ndarray) -> float:
        """Base radius at a direction of the pivot, the nearest that every row allows."""
        along = table @ [math.cos(z[0]), math.sin(z[0])]
        least = np.max(rhs[along < 0.0] / along[along < 0.0], initial=0.0)
        most = np.min(rhs[along > 0.0] / along[along > 0.0], initial=FREE["max"])
        return float(least * math.sin(z[0]) - OFFSET + 1e3 * max(least - most, 0.0))

    found = differential_evolution(
        worth, [(0.05, 1.5)], rng=7, tol=0.0, atol=1e-12, maxiter=400, popsize=40, polish=False
    )
    assert design.dimensions["base_radius_mm"] == pytest.approx(found.fun, rel=1e-6)


@pytest.mark.parametrize("sense", ["opposite", "same"])
@pytest.mark.parametrize(
    ("distance", "limits"), [(60.0, (RADIUS, PRESSURE, FACE)), (83.3, (RADIUS,))]
)
def test_at_a_given_distance_the_least_angle_is_found(
    sense: str, distance: float, limits: tuple[dict[str, Any], ...]
) -> None:
    spec = question(distance, *limits, sense=sense)
    design = synthesise(spec)
    table, rhs = rows(spec)

    def worst(psi: float) -> float:
        point = distance * np.array([math.cos(psi), math.sin(psi)])
        return float(np.max(table @ point - rhs))

    # from below: the first angle at which every row holds, closed in on by halving
    angles = np.linspace(math.asin(OFFSET / distance) + 1e-6, 0.5 * math.pi, 400)
    first = next(k for k, angle in enumerate(angles) if worst(angle) <= 0.0)
    low, high = angles[first - 1], angles[first]
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if worst(middle) > 0.0 else (low, middle)
    assert design.status == "optimal"
    base = distance * math.sin(high) - OFFSET
    assert design.dimensions["base_radius_mm"] == pytest.approx(base, rel=1e-6)
    assert design.certificate.lower_bound == pytest.approx(base, rel=1e-6)


def test_a_free_law_is_smaller_than_every_given_one_and_bounded_over_all_laws() -> None:
    limits = (RADIUS, PRESSURE, FACE)
    free = synthesise(question(60.0, *limits, JERK, law="spline", tolerance=1e-2))
    named = synthesise(question(60.0, *limits, law="polynomial_3_4_5"))
    assert free.certificate.certified
    assert free.status == "optimal"
    proof = free.certificate
    assert proof.lower_bound is not None
    assert proof.bound_valid_for == "all motion laws with a bounded jerk"
    assert proof.lower_bound <= free.dimensions["base_radius_mm"]
    assert free.dimensions["base_radius_mm"] < 0.97 * named.dimensions["base_radius_mm"]
    s = free.curve.derivatives(np.linspace(0.0, 2.0 * math.pi, 20001)) / 60.0
    psi, w = math.radians(free.dimensions["initial_angle_deg"]) + s[0], 1.0 + s[1]
    reach = 60.0 * np.cos(psi) / w
    radius = 60.0 * (np.sin(psi) * (1.0 - s[1] ** 2 / w**2) + np.cos(psi) * s[2] / w**3) - OFFSET
    assert np.max(reach) <= 50.0
    assert np.min(radius) >= 4.1
    assert np.max(abs(free.curve.derivatives(np.linspace(0.0, 6.28, 999))[3])) < math.inf


def another_program(sense: str, pieces: int, start: float) -> float:
    """The least base radius at d = 60 mm with piecewise constant jerks as unknowns, by IPOPT.

    Reach and radius are divided by w as in the textbooks, and asked for three times in a piece.
    """
    d, sigma, swing = 60.0, {"opposite": 1.0, "same": -1.0}[sense], math.radians(SWING)
    cap = math.radians(JERK["max_deg_per_s3"]) / (RPM * math.pi / 30.0) ** 3
    psi0 = casadi.SX.sym("psi0")
    unknowns, most, first = [psi0], [], [start]
    rows: list[Any] = []
    ends: list[Any] = []

    def limits(phi: Any, v: Any, a: Any) -> Any:
        w, psi = 1.0 + sigma * v, psi0 + phi
        reach = d * casadi.cos(psi) / w
        radius = d * casadi.sin(psi) * (1.0 + 2.0 * sigma * v) / w**2 - OFFSET
        radius += d * casadi.cos(psi) * a / w**3
        rows.extend([4.1 - radius, 20.0 - reach, reach - 50.0])
        return reach

    limits(0.0, 0.0, 0.0), limits(swing, 0.0, 0.0)  # on the dwells
    for angle, sign, field in ((81.0, 1.0, "rise_deg"), (97.0, -1.0, "return_deg")):
        beta, slope = math.radians(angle), math.tan(math.radians(PRESSURE[field]))
        j, width, g, v, a = casadi.SX.sym("j", pieces), 1.0 / pieces, 0.0, 0.0, 0.0
        for k in range(pieces):
            for h in (width / 3.0, 2.0 * width / 3.0, width):
                at = g + v * h + a * h**2 / 2 + j[k] * h**3 / 6
                speed, bend = v + a * h + j[k] * h**2 / 2, a + j[k] * h
                phi = swing * (at if sign > 0.0 else 1.0 - at)
                reach = limits(phi, sign * swing / beta * speed, sign * swing / beta**2 * bend)
                rows.extend([OFFSET - slope * reach, -speed])
            g, v, a = at, speed, bend
        ends += [g - 1.0, v, a]
        unknowns.append(j)
        most += [cap * beta**3 / swing] * pieces
        x = (np.arange(pieces) + 0.5) / pieces
        first += list(60.0 - 360.0 * x + 360.0 * x**2)  # the 3-4-5 law's
    program = {"x": casadi.vertcat(*unknowns), "f": psi0, "g": casadi.vertcat(*rows, *ends)}
    quiet = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"}
    solver = casadi.nlpsol("other", "ipopt", program, quiet)
    found = solver(
        x0=first, lbx=[0.05, *(-np.array(most))], ubx=[1.4, *most], ubg=0.0,
        lbg=[-casadi.inf] * len(rows) + [0.0] * len(ends),
    )  # fmt: skip
    assert solver.stats()["success"]
    return d * math.sin(float(found["x"][0])) - OFFSET


@pytest.mark.parametrize(("sense", "starts"), [("opposite", (0.4, 1.0)), ("same", (0.4,))])
def test_a_free_law_s_optimum_is_found_from_elsewhere_too(
    sense: str, starts: tuple[float, ...]
) -> None:
    """Other unknowns from other starts end in the same place, above the bound over all laws."""
    limits = (RADIUS, PRESSURE, FACE, JERK)
    ours = synthesise(question(60.0, *limits, sense=sense, law="spline", tolerance=1e-2))
    others = [another_program(sense, 24, start) for start in starts]
    assert others == pytest.approx(others[:1] * len(others), rel=1e-6)
    assert ours.certificate.certified
    # the other's rows hold at 144 points only
    assert ours.certificate.lower_bound <= min(others) * (1.0 + 1e-4)
    assert ours.certificate.lower_bound >= 0.98 * min(others)
    # with 40 and 64 pieces it falls by 1e-3 and by 2e-4 more
    assert ours.dimensions["base_radius_mm"] == pytest.approx(min(others), rel=1e-3)


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("sense", ["opposite", "same"])
def test_contact_that_leaves_the_face_is_found_with_its_angle(sense: str) -> None:
    spec = question(60.0, RADIUS, PRESSURE, FACE, sense=sense, base_radius_mm=37.0)
    reported, design = analyse(spec), synthesise(spec)
    assert reported.violated == ["face_far"]
    assert design.status == "infeasible"
    (broken,) = [e for e in reported.extremes if e.limit == "face_far"]
    assert extreme(design, "face_far") == broken
    theta, (phi, v, _), _ = dense(spec, 4001)
    sigma = {"opposite": 1.0, "same": -1.0}[sense]
    reach = 60.0 * np.cos(math.asin((37.0 + OFFSET) / 60.0) + phi) / (1.0 + sigma * v)
    assert broken.value == pytest.approx(np.max(reach), rel=1e-7)
    assert broken.angle_deg == pytest.approx(np.degrees(theta[np.argmax(reach)]), abs=0.05)
    assert reported.dimensions["face_far_mm"] == pytest.approx(np.max(reach), rel=1e-7)
    assert reported.remedy is not None
    (size,) = reported.remedy.sizes
    assert size.status == "optimal"


def test_a_pivot_that_may_not_come_nearer_stays_away() -> None:
    _, free = free_distance("opposite")
    least = free.dimensions["centre_distance_mm"] + 4.0
    kept = synthesise(question({"min": least, "max": 150.0}, RADIUS, PRESSURE, FACE))
    at = synthesise(question(least, RADIUS, PRESSURE, FACE))
    assert kept.certificate.certified
    assert kept.dimensions["centre_distance_mm"] == pytest.approx(least, rel=1e-3)
    assert kept.dimensions["base_radius_mm"] == pytest.approx(
        at.dimensions["base_radius_mm"], rel=2e-3
    )


def test_what_cannot_be_says_what_is_in_the_way(
    explain_only: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    explain_only("limits/1/rise_deg")
    monkeypatch.setattr("synthesis.pipeline.conflict.ACCURACIES", (0.2,))  # of the way
    design = synthesise(question(39.0, RADIUS, PRESSURE, FACE))
    assert design.status == "infeasible"
    assert design.conflict is not None
    assert any("pressure angle" in name for name in design.conflict.limits)


@pytest.mark.usefixtures("unexplained")
def test_the_outer_radius_of_a_given_cam_is_judged() -> None:
    free = synthesise(question(60.0, RADIUS))
    outer = 60.0 * math.sin(math.radians(free.dimensions["initial_angle_deg"] + SWING)) - OFFSET
    fits, tight = (
        synthesise(question(60.0, RADIUS, {"kind": "outer_radius", "max_mm": outer * factor}))
        for factor in (1.001, 0.999)
    )
    assert fits.status == "optimal"
    assert extreme(fits, "outer_radius").value == pytest.approx(outer, rel=1e-6)
    assert tight.status == "infeasible"


@pytest.mark.parametrize(("rotation", "offset"), [("ccw", OFFSET), ("ccw", 0.0), ("cw", -2.9)])
def test_every_format_is_written(rotation: str, offset: float) -> None:
    design = synthesise(question(83.3, RADIUS, offset=offset, rotation=rotation))
    assert design.status == "optimal"
    for exporter in PROFILE_FORMATS.values():
        assert len(written(exporter, design)) > 1000
    for exporter in MOTION_FORMATS.values():
        assert len(exporter.write(design, exporter.options())) > 1000


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"distance": {"min": 40.0}}, "centre_distance_open"),
        ({"swing": 85.0}, "face_turns_with_cam"),
        ({"swing": 85.0, "sense": "same"}, "face_turns_with_cam"),
        ({"base_radius_mm": 58.0}, "face_swings_too_far"),
        ({"limits": [{"kind": "face_width", "left_mm": 9.0}]}, "limit_does_not_suit"),
        ({"limits": [{"kind": "face_width", "width_mm": 9.0}]}, "limit_does_not_suit"),
        ({"limits": [{"kind": "face_width", "near_mm": 9.0, "far_mm": 8.0}]}, "face_ends_crossed"),
        ({"limits": [{"kind": "jerk", "max_mm_per_s3": 9.0}]}, "limit_unit_does_not_suit"),
    ],
)
def test_what_makes_no_sense_is_refused(change: dict[str, Any], rule: str) -> None:
    change = {"distance": 60.0, "limits": [], **change}
    with pytest.raises(ValidationError) as caught:
        question(change.pop("distance"), *change.pop("limits"), **change)
    assert rule in [error["type"] for error in caught.value.errors()]


def test_a_face_that_turns_with_the_cam_is_told_where() -> None:
    with pytest.raises(ValidationError, match=r"turns .* times as fast") as caught:
        question(60.0, sense="same", swing=85.0)
    (error,) = caught.value.errors()
    # the cycloid is fastest in the middle of the shorter move, at 2h/β
    assert error["ctx"]["at"] == pytest.approx(114.0 + 48.5, abs=1e-3) or (
        error["ctx"]["at"] == pytest.approx(40.5, abs=1e-3)
    )
    assert error["ctx"]["speed"] == pytest.approx(2.0 * 85.0 / 81.0, rel=1e-9)


def test_a_pivot_next_to_the_axis_is_led_away_from_it() -> None:
    """A tangent says how much farther it must be, also where the distance is almost nothing."""
    nearest, offset = 79.68, 0.0
    least = LeastPivotDistance("", nearest, offset)
    still, p, q = np.zeros((4, 1)), 2e-5, 1e-3
    step = 1e-6

    def excess(p: float, q: float) -> float:
        return float(least.excess(still, (p, q))[0][0])

    slope = np.array([
        excess(p + step, q) - excess(p - step, q), excess(p, q + step) - excess(p, q - step)
    ]) / (2.0 * step)  # fmt: skip
    # of 1 - r/R: -1/R along the radius
    assert slope * nearest == pytest.approx([-p / math.hypot(p, q), -q / math.hypot(p, q)], 1e-2)
    assert excess(nearest, 0.0) == pytest.approx(0.0, abs=1e-13)
