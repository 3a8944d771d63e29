"""The cam as a body, against other routes: Steiner's formulas, sums over vertices, differences."""

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import synthesis as c
from synthesis.design.design import Design
from synthesis.design.summary import CamGeometry
from synthesis.exporters.samples.cam import Cam
from tests.hard.random_specs import random_spec

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
TURN = 2.0 * math.pi
RISE_RETURN = [
    {"kind": "rise", "angle_deg": 100.0, "lift_mm": 12.0, "law": {"kind": "modified_sine"}},
    {"kind": "dwell", "angle_deg": 40.0},
    {"kind": "return", "angle_deg": 120.0, "lift_mm": 12.0, "law": {"kind": "polynomial_3_4_5"}},
    {"kind": "dwell", "angle_deg": 100.0},
]


def designed(follower: dict, radius: float, program=RISE_RETURN, **fields) -> Design:
    """A cam of a given size and given laws: nothing is solved."""
    return c.synthesise(
        c.DesignSpec.model_validate(
            {"speed_rpm": 300.0, "program": program, "follower": follower, "base_radius_mm": radius}
            | fields
        )
    )


def roller(**fields) -> dict:
    return {"kind": "translating_roller", "roller_radius_mm": 8.0, "offset_mm": 5.0, **fields}


def geometry(design: Design) -> CamGeometry:
    assert design.geometry is not None
    return design.geometry


def test_a_circle_off_its_axis():
    """A simple harmonic motion under a flat face: an eccentric circle of radius Rb + h/2."""
    law = {"kind": "simple_harmonic"}
    program = [
        {"kind": "rise", "angle_deg": 180.0, "lift_mm": 20.0, "law": law},
        {"kind": "return", "angle_deg": 180.0, "lift_mm": 20.0, "law": law},
    ]
    body = {"thickness_mm": 12.0, "density_kg_per_m3": 7800.0, "bore_mm": 18.0}
    design = designed({"kind": "translating_flat_face"}, 30.0, program, body=body)
    found, (flank,) = geometry(design), geometry(design).flanks
    area, e = math.pi * 40.0**2, 10.0
    polar = area * (0.5 * 40.0**2 + e * e)
    assert flank.perimeter_mm == pytest.approx(TURN * 40.0, rel=1e-12)
    assert flank.area_mm2 == pytest.approx(area, rel=1e-12)
    assert math.hypot(*flank.centroid_mm) == pytest.approx(e, rel=1e-12)
    assert flank.polar_moment_mm4 == pytest.approx(polar, rel=1e-12)
    assert flank.convex_radius_mm.value == pytest.approx(40.0, rel=1e-12)
    assert flank.hollow_radius_mm is None
    assert flank.hollows == 0
    assert flank.largest_radius_mm.value == pytest.approx(50.0, rel=1e-12)
    assert flank.largest_radius_mm.angle_deg == pytest.approx(180.0, abs=1e-5)
    # the face slides at ω (Rb + s): the cam's material passes below it (Rothbart)
    omega = 300.0 * TURN / 60.0
    assert flank.sliding_speed_mm_per_s.value == pytest.approx(omega * 50.0, rel=1e-12)
    hole = 0.25 * math.pi * 18.0**2
    mass = found.mass_properties
    assert mass.mass_kg == pytest.approx(7800.0 * 12e-9 * (area - hole), rel=1e-12)
    inertia = 7800.0 * 12e-9 * (polar - hole * 18.0**2 / 8.0) * 1e-6
    assert mass.moment_of_inertia_kg_m2 == pytest.approx(inertia, rel=1e-12)
    # a shaft in the spec is the bore where none is given
    shafted = {name: value for name, value in body.items() if name != "bore_mm"}
    same = designed(
        {"kind": "translating_flat_face"}, 30.0, program, body=shafted, shaft_diameter_mm=18.0
    )
    assert geometry(same).mass_properties == mass
    shift = area * e / (area - hole)
    assert math.hypot(*mass.centre_of_gravity_mm) == pytest.approx(shift, rel=1e-12)


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_integrals_are_steiners_and_those_of_many_triangles(rotation):
    """The pitch curve's length and area by a closed form of s; the flank's by Steiner's formulas.

    On a slide T² = (s' − e)² + X² and 2A = ∫ X² + e (e − s') dθ, X = s0 + s. The flank at the
    distance D inside has L − 2πD and A − LD + πD².
    """
    design = designed(roller(), 40.0, rotation=rotation)
    (flank,) = geometry(design).flanks
    e, s0 = design.size
    breaks = np.array(design.curve.curve.breaks)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    length = area = 0.0
    for low, high in pairwise(breaks.tolist()):
        s, v, *_ = design.curve.derivatives(0.5 * (high + low) + 0.5 * (high - low) * nodes, 1)
        w, x = 0.5 * (high - low) * weights, s0 + s
        length += float(w @ np.sqrt((v - e) ** 2 + x * x))
        area += 0.5 * float(w @ (x * x + e * (e - v)))
    assert flank.perimeter_mm == pytest.approx(length - TURN * 8.0, rel=1e-11)
    inner = area - 8.0 * length + math.pi * 64.0
    assert flank.area_mm2 == pytest.approx(inner, rel=1e-11)
    # moments of the polygon through points of the exported profile, by its error h² extrapolated
    first, polar = zip(*(polygon_moments(design, count) for count in (9000, 18000)), strict=True)
    centroid = (4.0 * first[1] - first[0]) / 3.0
    assert complex(*flank.centroid_mm) == pytest.approx(centroid, abs=2e-8)
    assert flank.polar_moment_mm4 == pytest.approx((4.0 * polar[1] - polar[0]) / 3.0, rel=1e-9)


def polygon_moments(design: Design, count: int) -> tuple[complex, float]:
    """Centroid and polar moment of the polygon through points of the exported profile."""
    cam = Cam.of(design)
    x, y = cam.place(cam.at(TURN * np.arange(count) / count))
    return polygon(x + 1j * y)


def bridged_polygon(design: Design, count: int) -> np.ndarray:
    """Points of the profile, so many on each piece, and on arcs about the roller's centre."""
    cam, found = Cam.of(design), []
    share = np.linspace(0.0, 1.0, count)
    for low, high in pairwise(design.curve.curve.breaks.tolist()):
        at = cam.at(low + (high - low) * share, np.arange(count) == count - 1)
        found.append(at.x + 1j * at.y)
        before, after = cam.at(np.array([high]), np.array([True])), cam.at(np.array([high % TURN]))
        centre = (after.pitch_x + 1j * after.pitch_y)[0]
        start, end = ((each.normal_x + 1j * each.normal_y)[0] for each in (before, after))
        turn = np.angle(end / start)
        found.append(centre - cam.gap * start * np.exp(1j * turn * share))
    return np.concatenate(found)


def polygon(p: np.ndarray) -> tuple[complex, float]:
    """Centroid and polar moment of a polygon, by its triangles from the axis."""
    q = np.roll(p, -1)
    cross = (np.conj(p) * q).imag
    area = 0.5 * cross.sum()
    polar = abs((cross * (abs(p) ** 2 + abs(q) ** 2 + (p * np.conj(q)).real)).sum()) / 12.0
    return complex((cross * (p + q)).sum() / (6.0 * area)), float(polar)


def example(name: str) -> Design:
    body = json.loads((EXAMPLES / f"{name}.json").read_text())["value"]
    return c.synthesise(c.DesignSpec.model_validate(body))


def test_extremes_are_those_of_a_local_search_on_the_exported_curve():
    """Curvature from the exporters' profile."""
    steep = [
        {**s, "angle_deg": a} for s, a in zip(RISE_RETURN, (55.0, 60.0, 65.0, 180.0), strict=True)
    ]
    design = designed(roller(offset_mm=0.0), 40.0, steep)
    (flank,), cam = geometry(design).flanks, Cam.of(design)

    def top(function, peak):
        near = math.radians(peak.angle_deg)
        around = (near - 0.02, near + 0.02)
        found = minimize_scalar(
            lambda t: -function(t), bounds=around, method="bounded", options={"xatol": 1e-11}
        )
        return max(-found.fun, function(near))

    def one(name):
        return lambda t: float(getattr(cam.at(np.array([t % TURN])), name)[0])

    assert flank.hollows == 2
    expected = 1.0 / top(one("curvature"), flank.convex_radius_mm) - 8.0
    assert flank.convex_radius_mm.value == pytest.approx(expected, rel=1e-10)
    hollow = 1.0 / top(lambda t: -one("curvature")(t), flank.hollow_radius_mm) + 8.0
    assert flank.hollow_radius_mm.value == pytest.approx(hollow, rel=1e-10)


SWING = [{k.replace("_mm", "_deg"): v for k, v in s.items()} for s in RISE_RETURN]
ARM = {"kind": "oscillating_roller", "roller_radius_mm": 9.0, "arm_mm": 80.0,
       "centre_distance_mm": 100.0}  # fmt: skip
FACE = {"kind": "oscillating_flat_face", "centre_distance_mm": 110.0, "face_offset_mm": 6.0}


def test_nothing_on_a_fine_grid_is_beyond_an_extreme():
    """Every figure of an arm's cam against 20,000 samples of the exporters' profile."""
    design = example("oscillating-roller")
    (flank,), cam = geometry(design).flanks, Cam.of(design)
    at = cam.at(TURN * np.arange(20_000) / 20_000)
    radius = np.hypot(*cam.place(at))
    assert flank.largest_radius_mm.value == pytest.approx(radius.max(), rel=1e-7)
    assert flank.smallest_radius_mm.value == pytest.approx(radius.min(), rel=1e-7)
    distance = 10.0
    convex, hollow = 1.0 / at.curvature.max() - distance, -1.0 / at.curvature.min() + distance
    assert flank.convex_radius_mm.value <= convex + 1e-9
    assert flank.convex_radius_mm.value == pytest.approx(convex, rel=1e-3)
    assert flank.hollow_radius_mm.value <= hollow + 1e-9
    assert flank.hollow_radius_mm.value == pytest.approx(hollow, rel=1e-3)


def test_the_outer_wall_of_a_groove_is_hollow_all_round():
    """One arc, the whole turn; and walls cut into a disc are no body that has a mass."""
    body = {"thickness_mm": 12.0, "density_kg_per_m3": 7800.0}
    groove = {"kind": "groove", "clearance_mm": 0.1, "rim_mm": 8.0}
    found = geometry(designed(roller(closure=groove), 60.0, body=body))
    assert [flank.hollows for flank in found.flanks] == [0, 1]
    assert [flank.hollow_radius_mm is None for flank in found.flanks] == [True, False]
    assert found.mass_properties is None


def test_a_point_of_the_cam_nearest_to_the_axis_is_never_missed():
    """A cam so sharp that the search between points of a grid ends above the lowest of them."""
    design = c.synthesise(c.DesignSpec.model_validate(random_spec(122)))
    (flank,), cam = geometry(design).flanks, Cam.of(design)
    near = math.radians(flank.smallest_radius_mm.angle_deg)
    radius = np.hypot(*cam.place(cam.at((near + np.linspace(-1e-3, 1e-3, 20_001)) % TURN)))
    assert flank.smallest_radius_mm.value <= radius.min() * (1.0 + 1e-12)


def test_a_corner_is_bridged_by_an_arc_about_the_rollers_centre():
    """A constant velocity meets dwells at corners: Steiner's formula with the pitch curve's own."""
    law = {"kind": "constant_velocity"}
    program = [{**segment, **({"law": law} if "law" in segment else {})} for segment in RISE_RETURN]
    design = designed(roller(offset_mm=0.0), 40.0, program)
    (flank,) = geometry(design).flanks
    (_, s0), length = design.size, 0.0
    for segment in design.curve.segments:
        v = segment.lift / segment.angle
        ends = s0 + np.array([segment.s_start, segment.s_end])
        if v == 0.0:
            length += segment.angle * float(ends[0])
        else:  # an Archimedean spiral: ∫ √(r² + v²) dr/v
            r = ends
            primitive = 0.5 * (r * np.hypot(r, v) + v * v * np.arcsinh(r / abs(v)))
            length += float(primitive[1] - primitive[0]) / v
    # about convex corners, which are undercut, arcs run backwards: Steiner's formula subtracts them
    turns = []
    for junction in range(design.curve.curve.count):
        breaks = design.curve.curve.breaks
        left = design.curve.derivatives([breaks[junction + 1]], 1, "left")[:, 0]
        right = design.curve.derivatives([breaks[junction + 1] % TURN], 1, "right")[:, 0]
        before, after = (math.atan2(s[1], s0 + s[0]) for s in (left, right))
        turns.append(before - after)
    backwards = sum(turn for turn in turns if turn > 0.0)
    assert flank.perimeter_mm == pytest.approx(length - 8.0 * (TURN - 2.0 * backwards), rel=1e-12)
    # the centroid of the polygon through pieces and arcs, in the cam's frame
    first, second = (bridged_polygon(design, count) for count in (2000, 4000))
    centroid = (4.0 * polygon(second)[0] - polygon(first)[0]) / 3.0
    assert complex(*flank.centroid_mm) == pytest.approx(centroid, abs=1e-8)
