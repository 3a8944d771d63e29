"""The roles of the solver, held to certified cams: this guards every row, cut and bound.

For each family of problems there is a pool of certified cams: those of the family's spec and of
neighbours with tighter limits, which satisfy its limits too. Then for each member of a role:

    relax, separate   every cam of the pool that lies in the domain satisfies every row and cut
    propagate         every cam at least as good as the value cap lies in the tightened domain
    dual_bound        no cam is below a bound, whatever the multipliers

A new limit, follower or cut is tested by one more family. The laws of the pool have knots of their
own, so that a bound or a row that holds for the splines of one mesh only is found out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synthesis.catalogue.motion import Motion
from synthesis.catalogue.objectives import Objective
from synthesis.certify.certificate import certify
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.branching.pivot_node import PivotNode
from synthesis.optimise.branching.traced_node import TracedNode
from synthesis.optimise.conic.control import Control, law_controls
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.conic.tangent_cuts import Region, TangentPoint
from synthesis.optimise.driver import optimise
from synthesis.optimise.dual_bound.bound import Bound, dual_bound
from synthesis.optimise.dual_bound.dual_ascent import improve_multipliers
from synthesis.optimise.problem.grid import grid_through, uniform_grid
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.propagation.bound_tightening import tighten_bounds
from synthesis.optimise.propagation.improving_region import ImprovingRegion, initial_region
from synthesis.optimise.propagation.law_tightening import (
    initial_law_bounds,
    size_bounds,
    tighten_law,
    with_value_cap,
)
from synthesis.optimise.recovery.candidate import Candidate, objective_value
from synthesis.optimise.relaxation.size_rows import (
    fixed_motion_rows,
    outside_ball_rows,
    tighten_sizes,
)
from synthesis.optimise.strategy import dimension_search
from synthesis.spec.design_spec import DesignSpec

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
ALLOWED = 2e-7  # relative: rows of a pool are kept to the solver's tolerance and tightening
POOL_TOLERANCE = 3e-2  # gap of the pool's cams: good ones and worse ones
TIGHTER = (0.0, 0.04)  # by which share the neighbours' limits are tighter
MESHES = (7, 16)  # intervals: other knots than those of any cam
DENSE = np.linspace(0.0, 1.0, 397)

FAMILIES: Mapping[str, Sequence[str]] = {  # an example, and objectives besides its own
    "example-13-6-sized": ("rms_jerk", "peak_acceleration"),
    "undercut-limit": ("rms_acceleration",),
    "flat-face": ("rms_jerk",),
    "oscillating-roller": ("rms_jerk",),
    "no-residual-vibration": ("peak_jerk",),
    "windows-and-points": ("rms_jerk",),
    "hertz-limited": (),
    "pivot-free": (),
    "swinging-face": (),
    "swinging-face-pivot-free": (),
    "arm-with-radius": (),
    "arm-with-radius-pivot-free": (),
}


def on_pivot(follower: Mapping[str, Any], radius: float, *limits: Mapping[str, Any]) -> Any:
    """A spec whose least profile radius binds on both laws."""
    jerk = {"kind": "jerk", "max_deg_per_s3": 1.9e6}

    def move(kind: str, angle: float) -> Mapping[str, Any]:
        return {"kind": kind, "angle_deg": angle, "lift_deg": 12.7, "law": {"kind": "spline"}}

    return {
        "speed_rpm": 143.0,
        "program": [
            move("rise", 87.3), {"kind": "dwell", "angle_deg": 31.9}, move("return", 94.1),
            {"kind": "dwell", "angle_deg": 146.7},
        ],
        "follower": follower,
        "limits": [{"kind": "profile_radius", "min_mm": radius}, jerk, *limits],
    }  # fmt: skip


FACE = {"kind": "oscillating_flat_face", "face_offset_mm": 2.3, "sense": "opposite"}
ARM = {"kind": "oscillating_roller", "arm_mm": 83.7, "roller_radius_mm": 9.1, "sense": "same"}
STEEPEST = {"kind": "pressure_angle", "rise_deg": 37.1, "return_deg": 35.3}
OWN: Mapping[str, Any] = {
    "swinging-face": on_pivot({**FACE, "centre_distance_mm": 103.1}, 6.1),
    "swinging-face-pivot-free": on_pivot(
        {**FACE, "centre_distance_mm": {"min": 91.0, "max": 131.0}}, 6.1
    ),
    "arm-with-radius": on_pivot({**ARM, "centre_distance_mm": 93.7}, 5.3, STEEPEST),
    "arm-with-radius-pivot-free": on_pivot(ARM, 5.3, STEEPEST),
}


@dataclass(frozen=True, eq=False)
class Family:
    """A problem under each of its objectives, and cams that satisfy its limits."""

    spec: DesignSpec
    problems: tuple[Problem, ...]
    cams: tuple[Candidate, ...]

    @property
    def problem(self) -> Problem:
        return self.problems[0]


def tightened(body: Mapping[str, Any], share: float) -> dict[str, Any]:
    """The spec with tighter limits: largest values smaller, least ones larger."""
    limits = []
    for limit in body["limits"]:
        factors = {
            key: 1.0 + share if key.startswith("min_") else 1.0 - share
            for key in limit
            if key.startswith(("min_mm", "max_", "rise_deg", "return_deg"))
        }
        limits.append(
            limit | {key: factor * limit[key] for key, factor in factors.items() if limit[key]}
        )
    return {**body, "limits": limits}


@pytest.fixture(scope="session", params=FAMILIES)
def family(request: pytest.FixtureRequest) -> Family:
    body = OWN.get(request.param)
    if body is None:
        body = json.loads((EXAMPLES / f"{request.param}.json").read_text())
        body = body.get("value", body)
    specs = [DesignSpec.model_validate(tightened(body, share)) for share in TIGHTER]
    others = [
        DesignSpec.model_validate({**body, "objective": {"kind": kind}}).objectives()[0]
        for kind in FAMILIES[request.param]
    ]
    objectives: list[Objective] = [specs[0].objectives()[0], *others]
    problem = formulate_problem(specs[0], objectives[0])
    cams, near = list[Candidate](), None
    for spec in specs:
        question = formulate_problem(spec, spec.objectives()[0])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(dimension_search, "STARTS", 3)
            for node in (TracedNode, PivotNode):  # they prove bounds, which no pool needs
                patch.setattr(node, "root", lambda _: None)
            state = optimise(question, POOL_TOLERANCE, warm_start=near)
        found, near = state.incumbent, state.local_optimum
        assert found is not None
        segments = [s for s in found.problem.segments if s.index in {f.index for f in problem.free}]
        cams.append(replace(found, problem=problem.with_laws(segments)))
    problems = tuple(replace(problem, objective=objective) for objective in objectives)
    return Family(specs[0], problems, tuple(cams))


def test_every_cam_of_the_pool_is_certified(family: Family):
    spec, machine = family.spec, family.spec.machine()
    for cam in family.cams:
        motion = Motion.of(cam.problem.segments)
        claims = certify(motion, machine, cam.size, spec.all_limits(), spec.continuity)
        assert [claim.limit for claim in claims if not claim.holds] == []


# -- relax: every row -----------------------------------------------------------------------------


def excess_on_own_mesh(model: ConicModel, cam: Candidate) -> float:
    """The largest violation of any row or cone of a program at a cam on its own knots."""
    program, x = model.program, model.point(cam.laws, cam.size)
    slack = program.rhs - program.matrix @ x
    worst = float(np.max(np.abs(slack[: program.equalities]), initial=0.0))
    at = program.equalities + program.inequalities
    worst = max(worst, float(np.max(-slack[program.equalities : at], initial=0.0)))
    for size in program.cones:
        worst = max(worst, float(np.linalg.norm(slack[at + 1 : at + size]) - slack[at]))
        at += size
    return worst


def excess_at_points(model: ConicModel, blocks: Sequence[LinearBlock], cam: Candidate) -> float:
    """The largest violation of rows, read as functionals of the cam's laws and size."""
    worst, size = 0.0, np.array(cam.size) / model.scales.size
    curves = [law.curve() for law in cam.laws]
    for block in blocks:
        if block.kind not in ("point", "size") or block.level or block.highest_order > 2:
            continue
        value = -block.rhs + (block.size @ size if len(block.size) else 0.0)
        if block.segment is not None:
            alpha = np.broadcast_to(block.alpha.T, (len(block.x), 4)).T
            for order in range(3):
                value = value + alpha[order] * curves[block.segment](block.x, order)
        worst = max(worst, float(np.max(np.abs(value) if block.exact else value, initial=0.0)))
    return worst


def own_mesh(family: Family, problem: Problem, cam: Candidate, region: Region) -> ConicModel:
    both = zip(problem.free, cam.laws, strict=True)
    return formulate(problem, [grid_through(s, law.space.breaks) for s, law in both], region=region)


def test_every_cam_satisfies_every_row(family: Family):
    for problem in family.problems:
        for cam in family.cams:
            model = own_mesh(family, problem, cam, Region(problem.sizing.bounds))
            assert excess_on_own_mesh(model, cam) <= ALLOWED
            for intervals in MESHES:
                other = formulate(problem, [uniform_grid(s, intervals) for s in problem.free])
                assert excess_at_points(other, other.blocks, cam) <= ALLOWED


# -- separate: every cut --------------------------------------------------------------------------


def pool_box(family: Family) -> tuple[tuple[float, float], ...]:
    """The least box of sizes with all cams in it."""
    sizes = np.array([cam.size for cam in family.cams])
    return tuple(zip(sizes.min(axis=0).tolist(), sizes.max(axis=0).tolist(), strict=True))


def test_every_cam_satisfies_cuts_that_are_tangent_at_another(family: Family):
    for other in family.cams:
        point = TangentPoint(tuple(law.curve() for law in other.laws), other.size)
        for sizes in (family.problem.sizing.bounds, pool_box(family)):
            for cam in family.cams:
                model = own_mesh(family, family.problem, cam, Region(sizes, (point,)))
                assert excess_on_own_mesh(model, cam) <= ALLOWED


def test_every_cam_satisfies_what_the_size_implies(family: Family):
    problem, box = family.problem, pool_box(family)
    scales = formulate(problem, [uniform_grid(s, 7) for s in problem.free]).scales
    norm = problem.objective.norm(problem.machine)
    blocks = list(fixed_motion_rows(problem, box, scales))
    if norm is not None:
        least = min(norm.value(cam.size) for cam in family.cams)
        blocks += outside_ball_rows(norm, least, box, scales)
    for cam in family.cams:
        for block in blocks:
            value = block.size @ (np.array(cam.size) / scales.size) - block.rhs
            assert np.max(value) <= ALLOWED
        kept = tighten_sizes(problem, problem.sizing.bounds)
        assert is_inside(cam.size, kept)


# -- propagate: every tightened domain ------------------------------------------------------------


def is_inside(size: Sequence[float], box: Sequence[tuple[float, float]]) -> bool:
    return all(
        low - ALLOWED * abs(low) <= value <= high + ALLOWED * abs(high)
        for value, (low, high) in zip(size, box, strict=True)
    )


def worst_value(family: Family) -> float:
    return max(objective_value(cam.problem, cam.size) for cam in family.cams)


def capped_model(family: Family) -> tuple[ConicModel, tuple[Control, ...]]:
    """Rows of every cam as good as the worst of the pool, and the caps of its laws."""
    free = {s.index: s for s in family.problem.segments}
    for segment in family.problem.free:
        assert segment.free is not None
        free[segment.index] = replace(segment, free=replace(segment.free, smoothness=2))
    problem = replace(family.problem, segments=tuple(free.values()))
    problem = with_value_cap(problem, worst_value(family) * (1.0 + 1e-6))
    model = formulate(problem, [uniform_grid(s, 12) for s in problem.free], region=Region())
    controls = law_controls(model)
    assert controls is not None
    assert all(np.isfinite(control.cap) for control in controls)
    return model, tuple(controls)


def test_every_cam_lies_in_the_bounds_of_laws_and_sizes(
    family: Family, request: pytest.FixtureRequest
):
    model, controls = capped_model(family)
    known = [initial_law_bounds(model, k, control) for k, control in enumerate(controls)]
    # as narrow as all cams of the pool allow
    box = tuple((min(ends), max(ends)) for ends in zip(*(c.size for c in family.cams), strict=True))
    bounds = [tighten_law(model, controls, box, k, each) for k, each in enumerate(known)]
    # and they are far narrower, where the mesh has a spline so good
    for before, after in zip(known, bounds, strict=True):
        width = before.high_speed - before.low_speed
        narrower = after.high_speed - after.low_speed < 0.5 * width
        assert np.all(narrower) or request.node.callspec.id in ("flat-face", "windows-and-points")
    box = size_bounds(model, controls, box)
    assert all(is_inside(cam.size, box) for cam in family.cams)
    for cam in family.cams:
        for law, bound in zip(cam.laws, bounds, strict=True):
            for order, (low, high) in enumerate(
                (bound.position_bounds(DENSE), bound.speed_bounds(DENSE))
            ):
                value = law.curve()(DENSE, order)
                assert np.min(value - low) >= -ALLOWED
                assert np.max(value - high) <= ALLOWED


def traced_region(
    family: Family, model: ConicModel, controls: Sequence[Control]
) -> ImprovingRegion:
    """The region of all cams as good as the worst of the pool, tightened once."""
    whole = dict.fromkeys(range(len(family.problem.free)), ((0.0, 1.0),))
    region = initial_region(model.problem, controls, whole)
    region, _ = tighten_bounds(model, controls, region, range(len(controls)))
    return region


def traced_point(family: Family, key: tuple[int, Any], cam: Candidate, x: Array) -> Array:
    """X, u, e and s'' of a cam's traced point along one law: (4, n)."""
    (position, coordinates), curve = key, cam.laws[key[0]].curve()
    segment = family.problem.free[position]
    s = [segment.lift / segment.angle**k * curve(x, k) for k in range(3)]
    s[0] = segment.s_start + s[0]
    return np.stack(np.broadcast_arrays(*coordinates.evaluate(s, cam.size), s[2]))


def of_the_pool(family: Family, region: ImprovingRegion) -> ImprovingRegion:
    """The least region with all cams in it: its cuts are as tight as they come."""
    narrow = {}
    for key, bounds in region.point_bounds.items():
        points = np.stack([traced_point(family, key, cam, bounds.nodes) for cam in family.cams])
        points = points[:, [0, 1, 3][: len(bounds.low)]]
        slack = ALLOWED * family.problem.length
        narrow[key] = replace(
            bounds, low=points.min(axis=0) - slack, high=points.max(axis=0) + slack
        )
    return replace(region, point_bounds=narrow).restrict(pool_box(family))


def test_every_cam_lies_in_the_region_and_satisfies_its_cuts(family: Family):
    model, controls = capped_model(family)
    region = traced_region(family, model, controls)
    for cam in family.cams:
        assert is_inside(cam.size, region.sizes)
        for key, bounds in region.point_bounds.items():
            low, high = bounds.at(DENSE)
            point, slack = (
                traced_point(family, key, cam, DENSE)[:3],
                ALLOWED * family.problem.length,
            )
            assert np.min(point - low) >= -slack
            assert np.max(point - high) <= slack
    for domain in (region, of_the_pool(family, region)):
        for other in (None, *family.cams):
            reference = None
            if other is not None:
                curves = tuple(law.curve() for law in other.laws)
                reference = TangentPoint(curves, other.size)
            own = replace(domain, reference=reference)
            blocks = [row for row, _, _ in own.rows(model, 0)]
            for cam in family.cams:
                assert excess_at_points(model, blocks, cam) <= ALLOWED


# -- dual_bound: every bound ----------------------------------------------------------------------


def bounds_of(problem: Problem, intervals: int) -> Iterator[Bound]:
    """Bounds on one mesh: of the solver's multipliers, of better ones and of arbitrary ones."""
    model = formulate(problem, [uniform_grid(s, intervals) for s in problem.free])
    solution = solve(model.program)
    if solution.stopped not in USABLE:
        return
    bound = dual_bound(model, solution)
    yield bound
    yield improve_multipliers(model, solution, bound, lambda _: False, 10.0)
    rng = np.random.default_rng(intervals)
    for spread in (0.05, 2.0):
        factors = rng.uniform(max(1.0 - spread, 0.0), 1.0 + spread, len(solution.multipliers))
        cones = model.program.equalities + model.program.inequalities
        factors[cones:] = 1.0
        yield dual_bound(model, replace(solution, multipliers=factors * solution.multipliers))


def test_no_cam_is_below_a_bound(family: Family):
    for problem in family.problems:
        values = [
            objective_value(replace(cam.problem, objective=problem.objective), cam.size)
            for cam in family.cams
        ]
        for intervals in MESHES:
            for bound in bounds_of(problem, intervals):
                if bound.valid_for.startswith("all motion laws"):
                    assert bound.value <= min(values) * (1.0 + 1e-9)
