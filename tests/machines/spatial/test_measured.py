"""What is measured of spatial cams, against formulas and brute force that share nothing with it."""

from __future__ import annotations

import math
from threading import Event
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial import KDTree

from synthesis.errors import Cancelled
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.design import SpatialDesign, SpatialExtreme
from synthesis.machines.spatial.measuring import enclosure
from synthesis.machines.spatial.measuring.enclosure import Prover
from synthesis.machines.spatial.measuring.measure import (
    RIB,
    contact_counts,
    follower_peaks,
    measure,
    segment_bound_extremes,
    thinnest_rib,
    to_wire,
)
from synthesis.machines.spatial.measuring.patches import Extremum, WallPoints, patches
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics import clock
from synthesis.units import DEGREE
from tests.machines.spatial.drums import SAMPLES, cam_points
from tests.machines.spatial.test_cam import body, cam_of

Array = NDArray[np.float64]
SPEED = 37.3


def design(**machine: Any) -> SpatialDesign:
    """An indexer of the tests' own sizes, its cam 107 mm wide."""
    changes = {"cam_width_mm": 107.3, "hand": "left"} | machine
    return synthesise_spatial(SpatialCamSpec(**body(**changes), speed_rpm=SPEED))


@pytest.fixture(scope="module")
def indexer() -> SpatialDesign:
    return design()


def extreme(of: SpatialDesign, quantity: str) -> SpatialExtreme:
    return next(each for each in of.extremes if each.quantity == quantity)


GLOBOIDAL = {hand: cam_of(SpatialCamSpec(**body(hand=hand))) for hand in ("left", "right")}
CAMS = GLOBOIDAL | {name: sample.cam() for name, sample in SAMPLES.items()}


@pytest.mark.parametrize("name", CAMS)
def test_the_judge_s_surface_says_what_contacts_say(name: str) -> None:
    """At points, where Taylor models are numbers: two sets of formulas, one cam."""
    cam: SpatialCam = CAMS[name]
    parts = list(patches(cam))
    models, rng = enclosure.Models(cam, parts), np.random.default_rng(3)
    roller = cam.swept.roller
    for i, part in enumerate(parts):
        theta = part.low + (part.high - part.low) * rng.random(4)
        rho = roller.inner + (roller.outer - roller.inner) * rng.random(4)
        at = enclosure.SweptAxis(models, np.stack([np.full(4, i), theta, theta, rho, rho]))
        found = part.at(theta, rho).contacts
        steep = np.tan(np.diag(found.pressure_angle)) ** 2
        assert np.abs(enclosure.pressure(at).c0 - steep).max() < 1e-12
        undercut = enclosure.undercut(roller.radius)(at).c0
        assert np.abs(undercut + np.diag(found.regular)).max() < 1e-12
        axis = tuple(cam.swept.axis)
        away = found.point - cam.swept.centre.reshape(3, 1, 1)
        along = np.diag(np.einsum("i,inm->nm", cam.swept.axis, away))
        assert np.abs(at.along(axis).c0 - along).max() < 1e-11 * roller.outer


def test_places_on_several_walls_are_those_of_each(indexer: SpatialDesign) -> None:
    """Every patch with angles and places of its own, all in one go and one by one."""
    cam, rng, each = indexer.cam, np.random.default_rng(7), 3
    parts = list(patches(cam))[::3]
    assert len({part.wall.side for part in parts}) == 2
    theta = np.array([part.low + (part.high - part.low) * rng.random(each) for part in parts])
    rho = rng.uniform(71.9, 102.4, (*theta.shape, 2))
    together = WallPoints(parts, theta, rho.reshape(-1, 2))
    slips, bends = together.contacts.slip, together.curvatures
    for i, part in enumerate(parts):
        rows = slice(each * i, each * (i + 1))
        one = part.at(theta[i], rho[i, 0])
        assert slips[:, rows][:, :1] == pytest.approx(one.contacts.slip[:, :1], rel=1e-12)
        assert bends[:, rows][:, :1] == pytest.approx(one.curvatures[:, :1], rel=1e-9)


def test_the_largest_pressure_angle_is_that_of_the_closed_form(indexer: SpatialDesign) -> None:
    """tan α = ρ|ψ'|/(C − ρ cos ψ), on as fine a grid as one likes, on walls that are there."""
    found, cam = extreme(indexer, "pressure_angle"), indexer.cam
    theta = np.linspace(0.0, math.radians(120.0), 200_001)
    q, q1 = cam.motion.derivatives(theta, 1)
    psi = q + math.radians(-30.0)
    outer = cam.swept.roller.outer
    closed = np.degrees(np.arctan(outer * q1 / (181.3 - outer * np.cos(psi))))
    assert found.value == pytest.approx(closed.max(), abs=1e-9)
    assert found.angle_deg == pytest.approx(np.degrees(theta[np.argmax(closed)]), abs=1e-3)
    assert (found.roller, found.rho_mm) == (2, outer)
    assert found.evidence == enclosure.EVIDENCE
    assert 0.0 <= found.width < 1e-6


def test_nothing_passes_a_proven_bound(indexer: SpatialDesign) -> None:
    cam, rng = indexer.cam, np.random.default_rng(11)
    steepest, flattest = 0.0, math.inf
    for part in patches(cam):
        theta = part.low + (part.high - part.low) * rng.random(60)
        found = part.at(theta, rng.uniform(71.9, 102.4, 40)).contacts
        there = cam.between_faces(found.point)
        steepest = max(steepest, float(found.pressure_angle[there].max(initial=0.0)))
        flattest = min(flattest, float(found.regular[there].min(initial=math.inf)))
    pressure, undercut = extreme(indexer, "pressure_angle"), extreme(indexer, "undercut")
    assert pressure.value is not None
    assert undercut.value is not None
    assert steepest / DEGREE <= pressure.value + pressure.width
    assert flattest >= undercut.value - undercut.width
    assert steepest / DEGREE == pytest.approx(pressure.value, rel=1e-2)
    assert flattest == pytest.approx(undercut.value, rel=0.1)


def test_curvatures_are_those_of_the_surface_an_offset_away(indexer: SpatialDesign) -> None:
    """Of a cylinder: 1/κ of the ruled surface that its axis sweeps, less the roller's radius."""
    cam = indexer.cam
    wall = next(wall for wall in cam.walls if wall.name == "2R")
    theta, rho = np.linspace(0.11, 1.5, 23), np.linspace(72.0, 102.0, 5)
    place = cam.place(wall.seat, theta)
    psi, q1, _ = (each[:, None] for each in place)
    room = 181.3 - rho * np.cos(psi)
    w = np.sqrt(room**2 + (rho * q1) ** 2)
    kappa = cam.swept.curvatures(place, rho, wall.side)
    gauss = kappa[0] * kappa[1] / ((1.0 + 29.1 * kappa[0]) * (1.0 + 29.1 * kappa[1]))
    # M of a ruled surface: u, its change and V span it; u_θ = ψ' w + J u, J about the cam's axis
    twist = (-q1 * room * 1.0 - rho * q1 * np.cos(psi)) / w
    assert gauss == pytest.approx(-(twist**2) / w**2, rel=1e-9)


def test_curvatures_are_infinite_where_undercut_begins() -> None:
    cam = cam_of(SpatialCamSpec(**body(centre_distance_mm=131.9)))
    wall = next(wall for wall in cam.walls if wall.name == "2L")
    rho = np.array([102.4])
    tried = np.linspace(0.1, 1.9, 400)
    area = cam.contacts(wall, tried, rho).regular[:, 0]
    first = int(np.flatnonzero(area < 0.0)[0])
    edge = brentq(
        lambda t: float(cam.contacts(wall, np.array([t]), rho).regular[0, 0]),
        tried[first - 1], tried[first], xtol=1e-15,
    )  # fmt: skip
    theta = np.array([edge - 1e-3, edge, edge + 1e-3])
    with np.errstate(all="raise"):
        kappa = cam.swept.curvatures(cam.place(wall.seat, theta), rho, wall.side)[:, :, 0]
    assert kappa[:, 1].tolist() == [math.inf, -math.inf]
    assert np.isfinite(kappa[:, [0, 2]]).all()


def test_a_small_pressure_angle_is_proven_as_closely_as_a_large_one() -> None:
    """tan α = 2 ρ (Ψ/β)/(C − ρ) in the middle of a cycloidal index, about 0.06°."""
    spec = SpatialCamSpec(**body(centre_distance_mm=1e5))
    cam = cam_of(spec)
    models = enclosure.Models(cam, list(patches(cam)))
    angle = math.atan(102.4 / (1e5 - 102.4))
    found = enclosure.prove_pressure_angle(models, Extremum(angle, math.nan, ""), None)
    assert angle <= found.limit < angle * (1.0 + 1e-6)


def roller_skins(cam: SpatialCam, start: float) -> Array:
    """Points all over a roller of a left-hand cam at many cam angles, as the cam has them."""
    theta = np.linspace(math.radians(30.0), math.radians(90.0), 300)
    rho, phi = np.array([71.9, 74.0, 87.0, 102.4]), np.linspace(0.0, 2.0 * math.pi, 240)
    t, r, a = (each.ravel() for each in np.meshgrid(theta, rho, phi, indexing="ij"))
    psi = start + cam.motion.derivatives(t, 0)[0]
    x = r * np.cos(psi) - 29.1 * np.cos(a) * np.sin(psi) - 181.3
    y, z = r * np.sin(psi) + 29.1 * np.cos(a) * np.cos(psi), 29.1 * np.sin(a)
    return np.stack([np.cos(t) * x - np.sin(t) * z, y, np.sin(t) * x + np.cos(t) * z], axis=1)


def test_a_rib_is_as_thick_as_the_next_roller_leaves_it(indexer: SpatialDesign) -> None:
    """Nearest neighbours of a wall's points among points of the next roller's whole skin."""
    found, cam = extreme(indexer, "rib_thickness"), indexer.cam
    assert found.angle_deg is not None
    assert 40.0 < found.angle_deg < 80.0
    theta, rho = np.radians(np.linspace(40.0, 80.0, 401)), np.linspace(71.9, 102.4, 9)
    nearest = math.inf
    for name, start in (("1L", -30.0), ("2L", -90.0), ("2R", 30.0), ("3R", -30.0)):
        wall = next(wall for wall in cam.walls if wall.name == name)
        there = cam.between_faces(cam.contacts(wall, theta, rho).point)
        points = cam_points(cam, wall, theta, rho)[:, there]
        skin = KDTree(roller_skins(cam, math.radians(start)))
        nearest = min(nearest, float(skin.query(points.T)[0].min(initial=math.inf)))
    assert found.value == pytest.approx(nearest, abs=2e-2)
    assert found.value is not None
    assert found.value <= nearest


def test_radii_are_the_least_of_many(indexer: SpatialDesign) -> None:
    cam = indexer.cam
    prove_convex_radius, prove_hollow_radius = 0.0, 0.0
    for part in patches(cam):
        theta, rho = np.linspace(part.low, part.high, 211), np.linspace(71.9, 102.4, 23)
        points = part.at(theta, rho)
        there, kappa = cam.between_faces(points.contacts.point), points.curvatures
        prove_convex_radius = max(prove_convex_radius, float(kappa[0][there].max(initial=0.0)))
        prove_hollow_radius = max(prove_hollow_radius, float(-kappa[1][there].min(initial=0.0)))
    convex, concave = extreme(indexer, "convex_radius").value, extreme(indexer, "hollow_radius")
    assert convex == pytest.approx(1.0 / prove_convex_radius, rel=2e-3)
    assert concave.value == pytest.approx(1.0 / prove_hollow_radius, rel=2e-3)
    assert concave.value is not None
    assert concave.value > 29.1  # no groove is narrower than its roller


@pytest.mark.parametrize(
    ("claim", "name"),
    [(enclosure.prove_convex_radius, "convex"), (enclosure.prove_hollow_radius, "hollow")],
)
def test_no_smaller_radius_is_proven_and_no_larger_one(
    indexer: SpatialDesign, claim: Prover, name: str
) -> None:
    reported, cam = extreme(indexer, f"{name}_radius"), indexer.cam
    assert reported.value is not None
    assert reported.evidence == enclosure.EVIDENCE
    assert reported.width <= 1.01e-2 * reported.value
    models = enclosure.Models(cam, list(patches(cam)))
    for share, proven in ((0.999, True), (1.03, False)):
        question = Extremum(-1.0 / (share * reported.value), 0.0, "asked")
        found = claim(models, question, None)
        assert (found.evidence == enclosure.EVIDENCE) is proven
    bound = 0.985 * reported.value
    bounded = claim(models, Extremum(-1.0 / reported.value, 0.0, ""), -1.0 / bound)
    assert -1.0 / bounded.limit > bound


def test_the_turret_s_peaks_are_the_law_s(indexer: SpatialDesign) -> None:
    """Cycloidal: 2, 2π and 4π² times Ψ/β, Ψ/β², Ψ/β³, at ω."""
    rate, index = SPEED * 6.0 / 120.0, 60.0
    for name, factor, order in (
        ("velocity", 2.0, 1),
        ("acceleration", 2.0 * math.pi, 2),
        ("jerk", 4.0 * math.pi**2, 3),
    ):
        expected = factor * index * rate**order
        assert extreme(indexer, name).value == pytest.approx(expected, rel=1e-9)


def slips(cam: SpatialCam, start: float, theta: Array, point: Array, rho: Array) -> list[Array]:
    """At contacts, by cross products: slip, what of it stays when the roller's middle rolls, rate.

    The rate is how fast the roller turns for that, against the cam.
    """
    q, q1 = cam.motion.derivatives(theta, 1)
    psi = (q + start)[:, None]
    u = np.stack([np.cos(psi), np.sin(psi), 0.0 * psi])
    across = np.cross(point - rho * u, u + 0.0 * point, axis=0) / 29.1
    moved = np.cross(np.array([0.0, 0.0, 1.0]), point, axis=0) * q1[:, None]
    away = point - np.array([181.3, 0.0, 0.0]).reshape(3, 1, 1)
    slip = moved - np.cross(np.array([0.0, 1.0, 0.0]), away, axis=0)
    rate = (slip * across).sum(axis=0)[:, [len(rho) // 2]]
    sizes = [np.sqrt((each**2).sum(axis=0)) for each in (slip, slip - rate * across)]
    return [*sizes, np.abs(rate) / 29.1 + 0.0 * sizes[0]]


def test_rollers_roll_at_their_middle_and_slide_elsewhere(indexer: SpatialDesign) -> None:
    cam, rho, most = indexer.cam, np.linspace(71.9, 102.4, 31), [0.0, 0.0, 0.0]
    for wall in cam.walls:
        for low, high in wall.spans:
            theta = np.linspace(low + 1e-9, min(high, math.radians(125.0)), 241)
            point = cam.contacts(wall, theta, rho).point
            found = slips(cam, wall.seat.start, theta, point, rho)
            there = cam.between_faces(point)
            most = [max(old, float(new[there].max())) for old, new in zip(most, found, strict=True)]
    omega = SPEED * 2.0 * math.pi / 60.0
    names = {"contact_speed": omega, "sliding_speed": omega, "roller_speed": SPEED}
    for (name, factor), largest in zip(names.items(), most, strict=True):
        assert extreme(indexer, name).value == pytest.approx(factor * largest, rel=2e-3)


def test_the_core_is_what_rims_of_rollers_leave(indexer: SpatialDesign) -> None:
    psi, phi = np.meshgrid(np.linspace(-1.5, 1.5, 801), np.linspace(0.0, 2.0 * math.pi, 241))
    x = 102.4 * np.cos(psi) - 29.1 * np.cos(phi) * np.sin(psi)
    nearest = np.hypot(x - 181.3, 29.1 * np.sin(phi)).min()
    assert indexer.dimensions["core_radius_mm"] == pytest.approx(nearest, abs=1e-3)
    assert extreme(indexer, "core_radius").value == indexer.dimensions["core_radius_mm"]


def test_some_wall_holds_the_turret_on_either_side(indexer: SpatialDesign) -> None:
    assert extreme(indexer, "contacts_left").value == 1.0
    assert extreme(indexer, "contacts_right").value == 1.0
    loose = cam_of(SpatialCamSpec(**body(cam_width_mm=41.0)))
    left = next(to_wire(kind, found, {}) for kind, found in contact_counts(loose))
    assert (left.quantity, left.value, left.holds) == ("contacts_left", 0.0, False)


def test_a_law_with_jumps_has_no_largest_jerk() -> None:
    question = body()
    question["program"][0]["law"] = {"kind": "parabolic"}
    spec = SpatialCamSpec(**question)
    *_, (kind, found) = follower_peaks(cam_of(spec), spec.machine.travel, spec.omega)
    jerk = to_wire(kind, found, {})
    assert (jerk.quantity, jerk.value) == ("jerk", None)
    assert jerk.evidence == "acceleration jumps there"


def test_ribs_that_rollers_cut_through_make_a_cam_infeasible() -> None:
    """Eight rollers of 25 mm on the same turret: 2 ρ sin(π/8) less two radii is 5 mm at most."""
    question = body(rollers=8, roller_radius_mm=29.0)
    question["program"][0] |= {"lift_deg": 45.0}
    spec = SpatialCamSpec(**question)
    cam = cam_of(spec)
    thinnest = thinnest_rib(cam, list(patches(cam)), spec.machine.seats())
    assert thinnest is not None
    rib = to_wire(RIB, thinnest, {})
    assert not rib.holds
    assert rib.value is not None
    assert rib.value < 2.0 * 71.9 * math.sin(math.pi / 8.0) - 58.0 + 1e-9
    assert rib.rho_mm == pytest.approx(71.9)


def test_undercut_is_a_result_with_its_place() -> None:
    """An index within 60° of the cam is too sudden for rollers of this radius."""
    question = body()
    question["program"][0] |= {"angle_deg": 60}
    question["program"][1] |= {"angle_deg": 300}
    found = synthesise_spatial(SpatialCamSpec(**question))
    undercut = extreme(found, "undercut")
    assert found.status == "infeasible"
    assert undercut.value is not None
    assert undercut.value < 0.0
    assert undercut.angle_deg is not None
    assert 0.0 < undercut.angle_deg < 60.0


def test_a_jump_of_the_velocity_breaks_the_walls() -> None:
    question = body()
    question["program"][0]["law"] = {"kind": "constant_velocity"}
    found = synthesise_spatial(SpatialCamSpec(**question))
    assert found.status == "infeasible"
    undercut = extreme(found, "undercut")
    assert (undercut.value, undercut.angle_deg, undercut.holds) == (None, 0.0, False)
    assert undercut.evidence.startswith("the velocity jumps there")
    assert extreme(found, "acceleration").value is None


def test_measuring_stops_where_nobody_waits() -> None:
    event, spec = Event(), SpatialCamSpec(**body())
    event.set()
    with pytest.raises(Cancelled), clock.cancellation_scope(event):
        measure(spec, cam_of(spec))


def test_windows_and_points_are_looked_at() -> None:
    """The cycloidal law is half way at the middle, and there at twice the mean speed."""
    question, speed = body(), SPEED * 6.0 / 120.0
    question["program"][0] |= {
        "points": [{"angle_deg": 60.0, "travel_deg": 30.0}],
        "windows": [{"from_deg": 40.0, "to_deg": 70.0,
                     "velocity_deg_per_s": {"max": 119.0 * speed}}],
    }  # fmt: skip
    spec = SpatialCamSpec(**question, speed_rpm=SPEED)
    found = {
        kind.name: to_wire(kind, each, {})
        for kind, each in segment_bound_extremes(spec, cam_of(spec))
    }
    assert {each.field for each in found.values()} == {
        "program/0/points/0/travel_deg", "program/0/windows/0/velocity_deg_per_s/max"
    }  # fmt: skip
    window = found.pop("program_0_window_0_velocity_max")
    assert window.value == pytest.approx(120.0 * speed)
    assert window.angle_deg == pytest.approx(60.0, abs=1e-6)
    assert not window.holds
    assert len(found) == 2
    for point in found.values():
        assert point.value == pytest.approx(30.0, abs=1e-12)
        assert point.holds
