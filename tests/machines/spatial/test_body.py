"""The body of a spatial cam: closed, of the right volume, and whole where no roller has been."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.machines.spatial.body import Blank, BlankOptions, build_body
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.body_mesh import STL, MeshOptions
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.drums import APART, SAMPLES, START
from tests.machines.spatial.test_cam import body, cam_of

Array = NDArray[np.float64]
COARSE = {"points_per_degree": 0.5, "depths": 7}
STEPS = 1500  # cam angles at which rollers are put into the body, one after the other
ERROR = 0.2  # mm: of so coarse a mesh


def made(spec: SpatialCamSpec) -> SpatialDesign:
    return synthesise_spatial(spec)


CAMS: dict[str, tuple[SpatialCamSpec, dict[str, Any]]] = {
    "turret": (SpatialCamSpec(**body()), {}),
    "turret, left, cut at a width": (
        SpatialCamSpec(**body(hand="left", mesh_angle_deg=52.3)),
        {"width_mm": 103.7, "bore_mm": 41.3},
    ),
    "groove": (SAMPLES["slide in a groove"].spec(), {"bore_mm": 23.1}),
    "rib": (SAMPLES["arm astride a rib"].spec(), {"tip_clearance_mm": 0.7}),
}


class Read:
    """A binary STL file, read as its format says."""

    def __init__(self, data: bytes) -> None:
        count = int.from_bytes(data[80:84], "little")
        assert len(data) == 84 + 50 * count
        numbers = np.frombuffer(data[84:], dtype="V50").reshape(-1, 1)
        floats = numbers.view(np.uint8).reshape(count, 50)[:, :48].copy().view("<f4")
        self.normals = floats[:, :3].astype(float)
        self.corners = floats[:, 3:].reshape(count, 3, 3).astype(float)

    @property
    def volume(self) -> float:
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return float(np.einsum("ni,ni->", a, np.cross(b, c))) / 6.0

    def edges(self) -> NDArray[np.int64]:
        """How often each directed edge is there, and how often the other way round."""
        _, names = np.unique(self.corners.reshape(-1, 3), axis=0, return_inverse=True)
        name = names.reshape(-1, 3)
        ends = np.concatenate([name[:, [0, 1]], name[:, [1, 2]], name[:, [2, 0]]])
        key, back = ends @ [len(names), 1], ends @ [1, len(names)]
        return np.array([np.unique(key, return_counts=True)[1].max(), len(np.setxor1d(key, back))])

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 3) are inside: solid angle of the surface (van Oosterom, Strackee)."""
        inside = []
        for point in points:
            a, b, c = np.moveaxis(self.corners - point, 1, 0)
            la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
            ab, bc, ca = (np.einsum("ni,ni->n", *pair) for pair in ((a, b), (b, c), (c, a)))
            top = np.einsum("ni,ni->n", a, np.cross(b, c))
            angle = 2.0 * np.arctan2(top, la * lb * lc + ab * lc + bc * la + ca * lb).sum()
            inside.append(angle > 2.0 * math.pi)
        return np.array(inside)


@pytest.fixture(scope="module", params=CAMS)
def cam(request: pytest.FixtureRequest) -> tuple[SpatialDesign, dict[str, Any], Read, float]:
    spec, options = CAMS[request.param]
    design = made(spec)
    file = STL.content(design, MeshOptions(**COARSE, **options))
    return design, options, Read(file.data), float(file.metadata["Surface-Error-Mm"])


def rollers_clear(design: SpatialDesign, points: Array) -> Array:
    """How far points of the cam's frame stay off all rollers' axes, less their radius [mm].

    By nothing but the motion and where the axes are; rollers reach to the cam's axis.
    """
    machine, sizes = design.spec.machine, design.dimensions
    theta = np.linspace(0.0, 2.0 * math.pi, STEPS, endpoint=False)
    q = design.curve.curve(theta)
    turret = design.machine == "globoidal_indexer"
    # a right-hand thread sends rollers upwards when the cam turns about the downward axis
    hand = -1.0 if turret and machine.hand == "right" else 1.0  # type: ignore[union-attr]
    turn = np.exp(1j * hand * theta)
    x_y = (points[:, 0] + 1j * points[:, 1])[:, None] * turn
    x, y, z = x_y.real, x_y.imag, np.broadcast_to(points[:, 2:], x_y.shape)
    best = np.full(len(points), np.inf)
    for seat in machine.seats():
        if turret:
            x_t, along = sizes["centre_distance_mm"] - x, np.exp(1j * (seat.start + q))
            away = np.hypot(along.real * z - along.imag * x_t, y)
            place = along.real * x_t + along.imag * z
            away = np.where((place > 0.0) & (x > 0.0), away, np.inf)
        else:
            away = np.hypot(y - seat_y(design, seat.start + q), z - seat_z(design, seat.start + q))
            away = np.where(x > 0.0, away, np.inf)
        best = np.minimum(best, away.min(axis=1))
    return best - sizes["roller_radius_mm"]


def seat_y(design: SpatialDesign, q: Array) -> Array:
    machine: Any = design.spec.machine
    if design.machine == "cylindrical_translating":
        return 0.0 * q
    reach = math.hypot(machine.arm_mm, 0.5 * machine.roller_distance_mm)
    return np.asarray(machine.pivot_distance_mm - reach * np.cos(q))


def seat_z(design: SpatialDesign, q: Array) -> Array:
    machine: Any = design.spec.machine
    if design.machine == "cylindrical_translating":
        return q
    reach = math.hypot(machine.arm_mm, 0.5 * machine.roller_distance_mm)
    return np.asarray(reach * np.sin(q))


def test_the_mesh_is_closed(cam: tuple[SpatialDesign, dict[str, Any], Read, float]) -> None:
    _, _, read, _ = cam
    often, open_ = read.edges()
    assert (often, open_) == (1, 0)
    assert np.linalg.norm(read.normals, axis=1) == pytest.approx(1.0, abs=1e-5)


def test_the_body_is_whole_where_no_roller_has_been(
    cam: tuple[SpatialDesign, dict[str, Any], Read, float],
) -> None:
    """Points all over the ribs' rim, told apart by rollers that know no contacts."""
    design, _, read, error = cam
    assert error < ERROR
    points = np.random.default_rng(7).choice(rim_points(design), 90, replace=False)
    clear = rollers_clear(design, points)
    far = np.abs(clear) > 2.0 * ERROR
    assert np.count_nonzero(far & (clear > 0.0)) > 15
    assert np.count_nonzero(far & (clear < 0.0)) > 15
    assert np.array_equal(read.holds(points[far]), clear[far] > 0.0)


def rim_points(design: SpatialDesign) -> Array:
    """Points of the blank that rollers can reach, in the cam's frame."""
    rng, sizes = np.random.default_rng(3), design.dimensions
    turn = rng.uniform(0.0, 2.0 * math.pi, 4000)
    if len(design.spec.machine.seats()) == 2:  # nothing is left but the rib between two rollers
        place = seat_z(design, design.curve.curve(-turn % (2.0 * math.pi)) + math.radians(START))
        height = rng.uniform(-1.0, 1.0, 4000) * 0.45 * APART + place
        radius = rng.uniform(48.2, 59.4, 4000)
        return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
    if design.machine == "globoidal_indexer":
        depth, across = rng.uniform(74.0, 101.0, 4000), rng.uniform(-0.45, 0.45, 4000)
        radius = sizes["centre_distance_mm"] - depth * np.cos(across)
        height = depth * np.sin(across)
    else:
        radius, height = rng.uniform(48.2, 59.4, 4000), rng.uniform(-13.0, 29.0, 4000)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def test_the_volume_is_that_of_its_slices() -> None:
    """A groove's cross-sections, integrated by Gauss's rule, for a cam whose ribs are two rings."""
    spec, options = CAMS["groove"]
    design = made(spec)
    fine = {"points_per_degree": 0.7, "depths": 7}
    file = STL.content(design, MeshOptions(**fine, **options))
    sizes = design.dimensions
    reach, radius = sizes["cylinder_radius_mm"], sizes["roller_radius_mm"]
    root = reach - 13.9 - 1.0
    width = 33.7 + 4.0 * radius
    # the groove: rollers in a row, each a slice of the groove at its depth
    theta = (np.arange(4000) + 0.5) * 2.0 * math.pi / 4000
    slope = np.gradient(design.curve.curve(theta), theta)
    depth, weight = np.polynomial.legendre.leggauss(12)
    rho = root + 0.5 * (reach - root) * (depth + 1.0)
    # unrolled at radius ρ, a strip along a line of length √(ρ² + s'²) per radian; that a roller
    # is not quite a circle there adds a few parts in ten thousand
    cut = np.mean(2.0 * radius * np.hypot(rho[:, None], slope), axis=1) * 2.0 * math.pi
    groove = 0.5 * (reach - root) * float(weight @ cut)
    whole = math.pi * (reach**2 - 11.55**2) * width
    assert Read(file.data).volume == pytest.approx(whole - groove, rel=1e-3)
    assert Read(file.data).volume == pytest.approx(float(file.metadata["Volume-Mm3"]), rel=1e-6)


@pytest.mark.parametrize(
    ("machine", "options", "reported"),
    [
        ({"mesh_angle_deg": 40.0}, {"bore_mm": 150.0}, "Choose a diameter below 147.6"),
        ({"mesh_angle_deg": 40.0}, {"tip_clearance_mm": 41.0}, "The grooves are 35.5545 mm deep"),
        ({"mesh_angle_deg": 40.0}, {"points_per_degree": 19.9, "depths": 90}, "Request at most"),
    ],
)
def test_what_leaves_no_body_is_refused(
    machine: dict[str, Any], options: dict[str, Any], reported: str
) -> None:
    design = made(SpatialCamSpec(**body(**machine)))
    with pytest.raises(InputError, match=reported):
        STL.write(design, MeshOptions(**options))


def test_a_wall_that_is_undercut_has_no_body() -> None:
    spec = SpatialCamSpec(**body(centre_distance_mm=131.9))
    cuts = GrooveSections(cam_of(spec), spec.machine)
    with pytest.raises(InputError, match="wall on the left side of a roller is undercut"):
        build_body(cuts, Blank.of(cuts, BlankOptions(), 4), 180)


def test_a_wall_that_only_longer_rollers_would_undercut_goes_straight_down() -> None:
    question = body(
        dwell_on="groove", roller_inner_mm=72.0, roller_radius_mm=30.0, roller_width_mm=30.0
    )
    question["machine"]["centre_distance_mm"] = 180.0
    question["program"][0]["law"] = {"kind": "cv50_half_sine"}
    spec = SpatialCamSpec(**question)
    cuts = GrooveSections(cam_of(spec), spec.machine)
    turn, depth = np.linspace(0.0, 2.2, 60), np.array([90.0, 101.9, 104.5, 107.3])
    for walls in cuts.grooves(turn, depth)[0]:
        whole = walls[np.all(np.isfinite(walls) & (np.abs(walls) < 1.4), axis=2)]
        assert np.max(np.abs(np.diff(whole, axis=1))) < math.radians(8.0)
        straight = whole[:, 2] == whole[:, 3]
        assert 0 < np.count_nonzero(straight) < 0.2 * len(straight)
