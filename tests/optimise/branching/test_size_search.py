"""Given laws with curvature: the least cam by boxes of sizes, against a search over all sizes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.catalogue.constraints import AffineNorm, NormBounds
from synthesis.numerics.box_search import Budget
from synthesis.numerics.piecewise import Array
from synthesis.optimise.branching.size_search import ANGLES as ANGLES_OF_SEGMENT
from synthesis.optimise.branching.size_search import BOXES, LEVELS, SizeSearch
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.relaxation.size_rows import is_excluded

LAWS = ("modified_sine", "cycloidal", "polynomial_3_4_5", "modified_trapezoid")
ANGLES = np.radians(np.linspace(0.0, 360.0, 901))


def scene(seed: int) -> dict[str, Any]:
    """A roller on a slide whose smallest radius of curvature decides, or nearly so."""
    rng = np.random.default_rng(seed)
    up, back = rng.uniform(55.0, 130.0, 2)
    top = rng.uniform(0.0, 40.0)
    lift, roller = rng.uniform(6.0, 24.0), rng.uniform(3.0, 13.0)
    law = {"kind": str(rng.choice(LAWS))}
    offset = [None, {"min": -0.4 * lift, "max": 0.3 * lift}, float(rng.uniform(-3.0, 3.0))]
    return {
        "speed_rpm": 97.0,
        "program": [
            {"kind": "rise", "angle_deg": up, "lift_mm": lift, "law": law},
            {"kind": "dwell", "angle_deg": top},
            {"kind": "return", "angle_deg": back, "lift_mm": lift, "law": law},
            {"kind": "dwell", "angle_deg": 360.0 - up - top - back},
        ],
        "follower": {
            "kind": "translating_roller",
            "roller_radius_mm": roller,
            "offset_mm": offset[seed % 3],
        },
        "limits": [
            {"kind": "pressure_angle", "rise_deg": rng.uniform(25.0, 60.0),
             "return_deg": rng.uniform(25.0, 60.0)},
            {"kind": "profile_radius", "min_mm": rng.uniform(0.5, 9.0)},
        ],
        "tolerance": 5e-3,
        "proof": "quick",
    }  # fmt: skip


def least_radius(design: Design) -> float:
    """The least base radius on a grid of offsets: by curvature of the centre's path, directly."""
    spec = design.spec
    follower: Any = spec.follower
    angle, radius = spec.limits
    motion = design.curve.derivatives(ANGLES[::2], 2)
    offset = follower.offset_mm
    near = design.dimensions["offset_mm"]
    span = 0.6 * design.dimensions["prime_radius_mm"]
    low, high = near - span, near + span
    if offset is not None:
        low, high = (offset, offset) if isinstance(offset, float) else (offset.min, offset.max)
    least = np.inf
    trial = np.linspace(0.0, 2.0 * design.dimensions["prime_radius_mm"], 801)
    for e in np.unique(np.linspace(low, high, 41)):
        # the set of radii need not be an interval: the first that holds, from below
        held = _keeps(trial[:, None], e, motion, follower.roller_radius_mm, angle, radius)
        if held[-1]:
            first = trial[int(np.argmax(held))]
            least = min(least, float(np.hypot(first, e)) - follower.roller_radius_mm)
    return least


def _keeps(s0: Array, e: float, motion: Array, roller: float, angle: Any, radius: Any) -> Array:
    """Which cams with the centre at (e, s0) at rest, s0 (k, 1), satisfy both limits: (k,)."""
    s, v, a = motion
    x, u = s0 + s, v - e
    up, down = np.tan(np.radians([angle.rise_deg, angle.return_deg]))
    steepest = np.where(v > 1e-9, up, np.where(v < -1e-9, down, np.inf))
    steep = np.abs(u) > steepest * np.maximum(x, 1e-300)
    speed = x * x + u * u
    bent = (speed + u * v - x * a) * (roller + radius.min_mm)
    return ~np.any((x <= 0.0) | steep | (bent > (1.0 + 1e-9) * speed**1.5), axis=1)


def face_scene(seed: int) -> dict[str, Any]:
    """A swinging face whose pivot may be no nearer than a least distance, which decides."""
    rng = np.random.default_rng(seed)
    up, back, swing = rng.uniform(60.0, 120.0), rng.uniform(60.0, 120.0), rng.uniform(9.0, 14.0)
    law = {"kind": str(rng.choice(LAWS))}
    nearest = rng.uniform(50.0, 90.0)
    return {
        "speed_rpm": 97.0,
        "program": [
            {"kind": "rise", "angle_deg": up, "lift_deg": swing, "law": law},
            {"kind": "dwell", "angle_deg": 31.7},
            {"kind": "return", "angle_deg": back, "lift_deg": swing, "law": law},
            {"kind": "dwell", "angle_deg": 328.3 - up - back},
        ],
        "follower": {
            "kind": "oscillating_flat_face",
            "centre_distance_mm": {"min": nearest, "max": nearest * rng.uniform(1.1, 2.0)},
            "face_offset_mm": rng.uniform(0.0, 6.0),
            "sense": ["same", "opposite"][seed % 2],
        },
        "limits": [{"kind": "profile_radius", "min_mm": rng.uniform(1.0, 6.0)}],
        "tolerance": 5e-3,
        "proof": "quick",
    }


def least_face_radius(design: Design) -> float:
    """The least base radius on a grid of centre distances: by the support function, directly."""
    spec = design.spec
    follower: Any = spec.follower
    (limit,) = (limit for limit in spec.limits if limit.kind == "profile_radius")
    phi, v, a = np.array(design.curve.derivatives(ANGLES[::3], 2)) / follower.reference
    w = 1.0 + {"opposite": 1.0, "same": -1.0}[follower.sense] * v
    least, ends = np.inf, follower.centre_distance_mm
    for distance in np.linspace(ends.min, ends.max, 21):
        start = np.linspace(0.0, 0.5 * np.pi - np.max(phi) - 1e-6, 1201)[:, None]
        psi = start + phi
        support = np.sin(psi) * (2.0 * w - 1.0) / w**2 + np.cos(psi) * a / w**3
        radius = distance * np.min(support, axis=1) - follower.face_offset_mm
        base = distance * np.sin(start[:, 0]) - follower.face_offset_mm
        held = (radius >= limit.min_mm - 1e-9) & (base > 0.0)
        least = min(least, float(np.min(base[held], initial=np.inf)))
    return least


def arm_scene() -> dict[str, Any]:
    """A roller on an arm whose pressure angle is nearly free: curvature decides."""
    law = {"kind": "polynomial_3_4_5"}
    return {
        "speed_rpm": 97.0,
        "program": [
            {"kind": "rise", "angle_deg": 73.0, "lift_deg": 19.0, "law": law},
            {"kind": "dwell", "angle_deg": 32.5},
            {"kind": "return", "angle_deg": 106.0, "lift_deg": 19.0, "law": law},
            {"kind": "dwell", "angle_deg": 148.5},
        ],
        "follower": {
            "kind": "oscillating_roller", "roller_radius_mm": 11.0, "arm_mm": 90.4,
            "centre_distance_mm": 56.9,
        },
        "limits": [{"kind": "pressure_angle", "rise_deg": 89.9, "return_deg": 89.9}],
    }  # fmt: skip


SEEDS = (24, 16, 20)  # the offset free, in a range, given
FACES = (1, 2)  # either sense


@pytest.mark.parametrize(
    ("question", "seed"), [*((scene, k) for k in SEEDS), *((face_scene, k) for k in FACES)]
)
def test_the_gap_of_given_laws_is_closed_and_no_size_is_below_the_bound(
    question: Callable[[int], dict[str, Any]], seed: int
) -> None:
    design = synthesise(DesignSpec.model_validate(question(seed)))
    assert design.status == "optimal"
    assert any(stage.stage == "sizes" for stage in design.report.stages)
    proof = design.certificate
    least = least_face_radius(design) if question is face_scene else least_radius(design)
    assert proof.bound_valid_for == "every size of the given laws"
    assert proof.value is not None
    assert proof.lower_bound is not None
    assert proof.lower_bound <= least
    assert proof.value <= least * (1.0 + 5e-3)


def test_a_box_of_sizes_with_a_cam_is_never_left() -> None:
    """Boxes about feasible sizes, of every width: whichever is excluded holds none."""
    rng = np.random.default_rng(11)
    for question in (*map(scene, SEEDS), *map(face_scene, FACES)):
        spec = DesignSpec.model_validate(question)
        problem = formulate_problem(spec, spec.objectives()[0])
        search = SizeSearch(optimise(problem, 0.5))
        best = search.state.incumbent
        assert best is not None
        feasible = np.array(best.size) * (1.0 + 1e-9)
        feasible[:-1] = best.size[:-1]
        width = 10.0 ** rng.uniform(-6.0, 1.0, (2, 40))
        share = rng.uniform(0.0, 1.0, (2, 40))
        low = feasible[:, None] - share * width
        boxes = np.stack([low, low + width], axis=1)
        least = -search.bound(boxes)
        inside = low + rng.uniform(0.0, 1.0, low.shape) * width
        for column, bounded in enumerate(least):
            for point in (feasible, inside[:, column], *boxes[:, :, column].T):
                assert bounded <= search.norm.value(tuple(point)) * (1.0 + 1e-12)


def test_the_angles_that_exceed_a_limit_most_exclude_what_all_angles_do() -> None:
    """Boxes on an arm and a slide, of every width: none is kept that some other angle excludes."""
    rng, excluded = np.random.default_rng(7), 0
    for question in (arm_scene(), *map(scene, SEEDS)):
        spec = DesignSpec.model_validate(question)
        problem = formulate_problem(spec, spec.objectives()[0])
        low, high = np.array(problem.sizing.bounds).T[:, :, None]
        low = low + rng.uniform(0.0, 1.0, (len(low), 60)) * np.minimum(high - low, 2.0)
        boxes = np.stack([low, low + 10.0 ** rng.uniform(-4.0, 0.0, low.shape)], axis=1)
        every = is_excluded(problem, boxes, ANGLES_OF_SEGMENT, worst=None)
        assert np.all(is_excluded(problem, boxes, ANGLES_OF_SEGMENT) >= every)
        excluded += int(np.sum(every))
    assert excluded > 40


def test_a_box_with_one_size_within_a_norm_s_range_is_kept() -> None:
    """That size is a corner: ‖a z + m‖² is rational, and the range's end next to its root."""
    rng, seen = np.random.default_rng(5), AffineNorm(((1.7, 0.0), (0.0, 0.9)), (0.3, 0.7))
    for _ in range(40):
        box = np.sort(rng.uniform(1.0, 9.0, (2, 2)), axis=1)
        nearest, farthest = (
            sum((Fraction(row[k]) * Fraction(z) + Fraction(m)) ** 2
                for k, (row, m, z) in enumerate(zip(seen.matrix, seen.shift, at, strict=True)))
            for at in box.T.tolist()
        )  # fmt: skip
        least, most = (float(square) ** 0.5 for square in (farthest, nearest))
        while Fraction(most) ** 2 < nearest:
            most = float(np.nextafter(most, np.inf))
        while Fraction(least) ** 2 > farthest:
            least = float(np.nextafter(least, 0.0))
        for bounds in ({"upper": most}, {"upper": np.inf, "lower": least}):
            assert not excluded_by(NormBounds(seen, source="", **bounds), box)
        # by a little more than rounding none is left
        for bounds in (
            {"upper": most * (1.0 - 1e-10)},
            {"upper": np.inf, "lower": least * (1.0 + 1e-10)},
        ):
            assert excluded_by(NormBounds(seen, source="", **bounds), box)


def excluded_by(bounds: NormBounds, box: Array) -> bool:
    question: Any = SimpleNamespace(segments=(), norm_bounds=[bounds], least_norms=[])
    return bool(is_excluded(question, box[:, :, None])[0])


def test_a_search_that_ends_early_proves_no_more_than_its_boxes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("synthesis.optimise.branching.size_search.BOXES", 9)
    design = synthesise(DesignSpec.model_validate(scene(6)))
    assert design.status == "feasible"
    gap = design.certificate.gap
    assert gap is not None
    assert gap > 0.05


def test_a_search_whose_time_is_over_ends_after_its_first_level() -> None:
    spec = DesignSpec.model_validate(scene(SEEDS[0]))
    state = optimise(formulate_problem(spec, spec.objectives()[0]), 0.5)
    assert state.incumbent is not None
    size = np.array(state.incumbent.size)
    boxes = np.stack([size - 0.5 * abs(size), size + 0.5 * abs(size)], axis=1)[:, :, None]
    ended = SizeSearch(replace(state, deadline=0.0, tolerance=1e-9))
    assert not ended.run(boxes, Budget(LEVELS, BOXES))
    assert ended.count == 1
    assert np.all(ended.proven >= -np.inf)
    going = SizeSearch(replace(state, tolerance=1e-9))
    going.run(boxes, Budget(LEVELS, 20))
    assert going.count > 1
