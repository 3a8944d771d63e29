"""What Hertz pressure on a roller implies, against the pressure of the textbooks and feasible cams.

Nothing of the product's forms is used to say what a cam is worth: forces and curvature come from
the roller centre's path as complex numbers.
"""

from copy import deepcopy
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis import Design, DesignSpec, synthesise
from synthesis.catalogue.constraints import MotionBox
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.propagation.improving_region import initial_region
from synthesis.optimise.relaxation.size_rows import tighten_sizes

RPM, MASS, DAMPING, RATE, PRELOAD, WIDTH, ROLLER = 317.0, 2.1, 31.0, 6.3, 410.0, 12.3, 9.7
RISE, LIFT, JERK = 71.3, 28.9, 2.7e7
STIFF = 2.0 * pi * WIDTH * (1.0 - 0.3**2) / 206e3
OMEGA = RPM * pi / 30.0
POINTS = [(7.0, 0.0), (58.0, 480.0), (97.0, 480.0), (97.0, 0.0)]
BODY = {
    "speed_rpm": RPM,
    "program": [
        {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 25.7},
        {"kind": "return", "angle_deg": 83.1, "lift_mm": LIFT, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 179.9},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": ROLLER},
    "load": {
        "kind": "slide", "moving_mass_kg": MASS, "damping_n_s_per_m": DAMPING,
        "spring": {"rate_n_per_mm": RATE, "preload_n": PRELOAD},
        "process": [{"angle_deg": a, "force_n": f} for a, f in POINTS],
        "contact": {"width_mm": WIDTH},
    },
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30, "return_deg": 45},
        {"kind": "jerk", "max_mm_per_s3": JERK},
        {"kind": "hertz_pressure", "max_mpa": 690.0},
    ],
    "tolerance": 5e-3,
}  # fmt: skip


def spec_of(**more) -> DesignSpec:
    return DesignSpec.model_validate({**deepcopy(BODY), **more})


def process(degrees: np.ndarray) -> np.ndarray:
    """The process force before a jump and after it, whichever is larger [N]."""
    found = np.interp(degrees, *zip(*POINTS[:3], strict=True))
    return np.where((degrees < 7.0) | (degrees > 97.0), 0.0, found)


def pressed(theta, s, v, a, e, s0, *, side=1, slack=0.0, friction=0.0, spring=(RATE, PRELOAD)):
    """Signed p² [MPa²], tan α and 1 − D σκ of a roller on a slide, from its centre's path."""
    centre = e + 1j * (s0 + s)
    velocity = 1j * v - 1j * centre  # as seen from the turning cam
    bent = 1j * a + v - 1j * velocity
    speed = np.abs(velocity)
    bend = -side * np.imag(np.conj(velocity) * bent) / speed**3  # it runs clockwise
    normal = 1j * velocity / speed
    normal = np.where(np.real(normal * np.conj(centre)) < 0.0, -normal, normal)
    cosine, sine = np.imag(normal), np.real(normal)
    drive = MASS * a * OMEGA**2 * 1e-3 + DAMPING * v * OMEGA * 1e-3 + spring[0] * s + spring[1]
    force = side * (drive + process(np.degrees(theta))) / (cosine - friction * np.abs(sine))
    left = 1.0 - (ROLLER + slack) * bend
    return force / STIFF * (1.0 / ROLLER + bend / left), sine / cosine, left


def points(seed: int, width: float):
    """A box of motions and sizes of the rise, and points in it."""
    draw = np.random.default_rng(seed)
    low = np.array([draw.uniform(2, 22), draw.uniform(-5, 25), draw.uniform(-70, 60),
                    draw.uniform(-12, 15), draw.uniform(24, 60)])  # fmt: skip
    span = width * np.array([4.0, 6.0, 60.0, 5.0, 6.0])
    share = draw.random((5, 40))
    share[:, :12] = share[:, :12].round()
    return low, low + span, low[:, None] + span[:, None] * share, draw


MACHINES = {  # closure, and μ of the guide
    "spring": ({"kind": "force"}, 0.0),
    "friction": ({"kind": "force"}, 0.31),
    "ring": ({"kind": "force", "contact": "inside"}, 0.0),
    "groove": ({"kind": "groove", "clearance_mm": 0.3}, 0.0),
}


def machine_of(name: str) -> tuple[DesignSpec, tuple[float, float]]:
    """The spec, and rate and preload as they act on the drive."""
    closure, mu = MACHINES[name]
    body = deepcopy(BODY)
    body["follower"]["closure"] = closure
    if mu:
        body["load"]["friction"] = {"coefficient": mu}
    if name == "groove":
        del body["load"]["spring"]
    spring = {"ring": (RATE, -PRELOAD), "groove": (0.0, 0.0)}.get(name, (RATE, PRELOAD))
    return DesignSpec.model_validate(body), spring


def row_of(traced, theta, low, high):
    """The row implied in a box of (s, s', s'', e, s0): its factors of these, and its bound."""
    (s, v, _, e, s0), (s_, v_, _, e_, s0_) = low, high
    x = np.array([[s0 + s, s0_ + s_], [v - e_, v_ - e], [e, e_]])
    known = MotionBox(np.array([theta]), low[:3, None], high[:3, None])
    (cuts,) = traced.linear_relaxation(x[:, :1], x[:, 1:], None, known)
    return np.concatenate([cuts.coefficients[:3, 0], cuts.size[:, 0]]), float(cuts.upper[0])


@pytest.mark.parametrize("name", MACHINES)
@settings(max_examples=15)
@given(st.integers(0, 10**6), st.floats(1e-3, 1.0), st.sampled_from(["rise", "return"]))
def test_no_cam_that_keeps_the_limit_is_cut_off(name, seed, width, kind):
    low, high, at, draw = points(seed, width)
    spec, spring = machine_of(name)
    segment = next(s for s in spec.placed_segments() if s.kind == kind)
    theta = segment.start + segment.angle * draw.random()
    sliding = MACHINES[name][1] * (1.0 if kind == "rise" else -1.0)
    for k, flank in enumerate(spec.follower.flanks):
        squares, _, left = pressed(
            theta, *at, side=flank.side, slack=flank.slack, friction=sliding, spring=spring
        )
        kept = np.flatnonzero((left > 0.0) & (squares > 1.0))[:12]
        for point, square in zip(at.T[kept], squares[kept], strict=True):
            # a limit that this very point just keeps
            just = spec.limits[2].model_copy(update={"max_mpa": float(np.sqrt(square))})
            factors, upper = row_of(
                just.curvature_bounds(segment, spec.machine())[k], theta, low, high
            )
            size = np.abs(factors * point).sum() + np.abs(upper) + 1.0
            assert factors @ point <= upper + 1e-9 * size


@pytest.mark.parametrize("name", ["spring", "friction", "ring"])
def test_where_all_is_known_the_row_is_the_limit(name):
    """In a box of no width the row is met where the pressure is the largest allowed."""
    spec, spring = machine_of(name)
    segment = spec.placed_segments()[0]
    (flank,) = spec.follower.flanks
    theta, checked = segment.start + 0.37 * segment.angle, 0
    for seed in range(40):
        low, *_ = points(seed, 0.0)
        square, _, left = pressed(
            theta, *low, side=flank.side, friction=MACHINES[name][1], spring=spring
        )
        if left <= 0.0 or square <= 1.0:
            continue
        just = spec.limits[2].model_copy(update={"max_mpa": float(np.sqrt(square))})
        factors, upper = row_of(just.curvature_bounds(segment, spec.machine())[0], theta, low, low)
        assert factors @ low == pytest.approx(upper, abs=1e-9 * np.abs(factors * low).sum())
        checked += 1
    assert checked >= 5


LEAST = 32.0  # of the peak of g''', that of the law with the smallest


def laws(draw, count: int, cap: float):
    """Random laws g to g''' (4, count, n) from rest to rest, none falling, |g'''| ≤ cap; x (n,)."""
    x = np.linspace(0.0, 1.0, 401)
    t = np.minimum(x, 1.0 - x)
    u = t - 0.25
    first = np.stack([16.0 / 3.0 * t**3, 16.0 * t**2, 32.0 * t, 32.0 + 0.0 * t])
    then = np.stack(
        [1.0 / 12.0 + u + 4.0 * u**2 - 16.0 / 3.0 * u**3, 1.0 + 8.0 * u - 16.0 * u**2,
         8.0 - 32.0 * u, -32.0 + 0.0 * u]
    )  # fmt: skip
    base = np.where(t < 0.25, first, then)
    late = x > 0.5
    base[0, late], base[2, late] = 1.0 - base[0, late], -base[2, late]
    found = []
    bump = np.polynomial.Polynomial([0, 0, 0, 1, -3, 3, -1])
    while len(found) < count:
        wave = bump * np.polynomial.Polynomial(draw.normal(size=5))
        parts = np.stack([wave(x), *(wave.deriv(k)(x) for k in (1, 2, 3))])
        law = base + draw.uniform(-1.0, 1.0) * (cap - LEAST) / np.max(np.abs(parts[3])) * parts
        if np.min(law[1]) >= -1e-12:
            found.append(law)
    return np.stack(found, axis=1), x


def smallest(limit: float, e: np.ndarray, draw, near: Design) -> np.ndarray:
    """Prime radii of random cams, each as small as limits at 401 angles of both laws allow.

    Their laws lie between a design's and random ones: there jerk and sense of motion are kept, too.
    """
    cap, reported = JERK / OMEGA**3 / LIFT, []
    for start, angle, way, steep in ((0.0, RISE, 1.0, 30.0), (97.0, 83.1, -1.0, 45.0)):
        width = np.radians(angle)
        g, x = laws(draw, len(e), cap * width**3)
        s = np.stack([way * LIFT * g[k] / width**k for k in range(3)])
        s[0] += 0.0 if way > 0.0 else LIFT
        theta = np.radians(start) + width * x
        own, share = near.curve.derivatives(theta, 2), draw.random((len(e), 1)) ** 3
        s = (1.0 - share) * own[:, None] + share * s
        reported.append((theta, s, np.tan(np.radians(steep))))
    low, high = np.full(len(e), 5.0), np.full(len(e), 300.0)
    for _ in range(45):
        middle, good = 0.5 * (low + high), np.ones(len(e), dtype=bool)
        for theta, s, steep in reported:
            square, slope, left = pressed(theta, *s, e[:, None], middle[:, None])
            kept = (np.abs(slope) <= steep) & (left > 0.0) & (square <= limit**2)
            good &= np.all(kept, axis=1)
        low, high = np.where(good, low, middle), np.where(good, middle, high)
    assert np.all(high < 300.0)
    return np.hypot(e, high)


@pytest.fixture(scope="module")
def proven():
    return tuple(synthesise(spec_of(proof=proof)) for proof in ("quick", "thorough"))


def test_the_gap_is_closed_where_hertz_pressure_binds(proven):
    quick, thorough = proven
    without = synthesise(spec_of(limits=BODY["limits"][:2])).certificate
    reported = {extreme.limit: extreme for extreme in thorough.extremes}["hertz_pressure"]
    assert reported.value == pytest.approx(690.0, rel=2e-3)
    assert thorough.status == "optimal"
    assert thorough.certificate.gap <= 5e-3
    assert thorough.certificate.bound_valid_for == "all motion laws with a bounded jerk"
    # what the problem without the limit would say
    assert (quick.certificate.value - without.lower_bound) / quick.certificate.value > 0.06
    assert quick.certificate.gap < 0.03


def test_no_feasible_cam_is_better_than_the_bound(proven):
    draw = np.random.default_rng(11)
    best = proven[1]
    offsets = best.dimensions["offset_mm"] + draw.normal(size=100) * draw.random(100)
    radii, lower = smallest(690.0, offsets, draw, best), best.certificate.lower_bound + ROLLER
    assert np.min(radii) >= lower
    assert np.count_nonzero(radii < 1.03 * lower) > 3  # some of them are good


def test_a_dwell_alone_needs_a_size():
    """Along a concentric arc p² = N/B · 1/(r (1 − r/W)) under the middle: W in closed form."""
    course = ((75, 0), (80, 700), (90, 700), (95, 0))
    points_ = [{"angle_deg": angle, "force_n": force} for angle, force in course]
    spec = spec_of(load={**BODY["load"], "process": points_})
    problem = formulate_problem(spec, *spec.objectives())
    force, limit = RATE * LIFT + PRELOAD + 700.0, 690.0**2 * STIFF
    arc = ROLLER / (1.0 - force / (limit * ROLLER))
    (e, e_), (low, high) = tighten_sizes(problem, ((0.0, 0.0), (5.0, 400.0)))
    assert (e, e_, high) == (0.0, 0.0, 400.0)
    assert 0.999 * (arc - LIFT) <= low <= arc - LIFT
    _, (low, high) = tighten_sizes(problem, ((0.0, 0.0), (5.0, 0.98 * (arc - LIFT))))
    assert low > high  # nothing is left
    draw = np.random.default_rng(3)
    offset, height = draw.uniform(-60, 60, 4000), draw.uniform(5, 400, 4000)
    reach = np.hypot(offset, height + LIFT)
    kept = force * reach / (height + LIFT) * (1 / ROLLER + 1 / (reach - ROLLER)) <= limit
    (e, e_), (low, high) = tighten_sizes(problem, ((-60.0, 60.0), (5.0, 400.0)))
    assert np.count_nonzero(kept) > 100
    assert np.all((e <= offset[kept]) & (offset[kept] <= e_))
    assert np.all((low <= height[kept]) & (height[kept] <= high))


def test_bounds_of_the_traced_point_and_of_the_motion_imply_rows():
    """Within narrow bounds about a 3-4-5 motion."""
    spec = spec_of()
    problem = formulate_problem(spec, *spec.objectives())
    model = formulate(problem, [uniform_grid(segment, 20) for segment in problem.free])
    controls = law_controls(model)
    assert controls is not None
    size = (3.1, 41.0)
    sizes = tuple((z - 1e-3, z + 1e-3) for z in size)
    region = initial_region(problem, controls, {0: ((0.1, 0.9),)}).restrict(sizes)
    ((_, coordinates), bounds), *_ = region.point_bounds.items()
    x, rise = bounds.nodes, problem.free[0]
    course = np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
    s = [rise.lift / rise.angle**k * course.deriv(k)(x) for k in range(3)]
    height, speed, _ = coordinates.evaluate(s, size)
    point = np.stack([height, speed, s[2]])
    near = replace(bounds, low=point - 1e-3, high=point + 1e-3, cap=1.0)
    near_rows = replace(region, point_bounds={(0, coordinates): near}).rows(model, 0)
    blocks = [row for row, _, _ in near_rows]
    assert "hertz_pressure" in {block.source for block in blocks}


def test_without_a_jerk_limit_the_answer_says_what_its_bound_leaves_out():
    limits = deepcopy(BODY["limits"])
    limits[1] = {"kind": "acceleration", "max_mm_per_s2": 1.3e5}
    reported = synthesise(spec_of(limits=limits, proof="thorough")).certificate
    assert reported.gap > 5e-3
    assert reported.bound_valid_for == (
        "all motion laws with a bounded acceleration; not wholly in it: hertz_pressure, which a "
        "thorough proof takes in where every free law has a limit on jerk"
    )
