"""A cam that is nowhere undercut and still cuts itself is found, and an ordinary one is cleared."""

import math

import numpy as np
import pytest

from synthesis.catalogue.followers import TranslatingFlatFace, TranslatingRoller
from synthesis.catalogue.followers.closures import Groove
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.limits import Machine
from synthesis.catalogue.limits.radii import ProfileRadius
from synthesis.catalogue.motion import Motion
from synthesis.certify import certificate, certify
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.certify.quantities import MeasuredCam
from synthesis.certify.roller_interference import NearestPair, OffsetProfile, nearest_far_pair
from synthesis.certify.self_intersection import clear_flanks, roller_clearances
from synthesis.design.design import Extreme
from tests.certify.cams import motion_of
from tests.certify.crossing import Horseshoe, brute, pitch, sharpest

SMOOTH = ("cycloidal", "polynomial_3_4_5", "polynomial_4_5_6_7", "modified_sine", "peisakh_11")


def random_motion(rng: np.random.Generator) -> Motion:
    """A rise, a dwell, a return and a dwell of uneven angles, gentle laws."""
    lift = rng.uniform(21.0, 93.0)
    angles = rng.uniform([21.0, 5.0, 21.0, 101.0], [73.0, 61.0, 73.0, 199.0])
    rise, back = (LAWS[name] for name in rng.choice(SMOOTH, 2))
    return motion_of([
        ("rise", angles[0], lift, rise.curve("rise")),
        ("dwell", angles[1], 0.0, None),
        ("return", angles[2], lift, back.curve("return")),
        ("dwell", angles[3], 0.0, None),
    ])  # fmt: skip


def thin_lobed(rng: np.random.Generator) -> Motion:
    """A high and narrow lobe: its root is thin where the base radius is small."""
    lift = rng.uniform(49.0, 71.0)
    angles = rng.uniform([53.0, 5.0, 51.0], [69.0, 19.0, 71.0])
    rise, back = (LAWS[name] for name in rng.choice(SMOOTH, 2))
    return motion_of([
        ("rise", angles[0], lift, rise.curve("rise")),
        ("dwell", angles[1], 0.0, None),
        ("return", angles[2], lift, back.curve("return")),
        ("dwell", 360.0 - angles.sum(), 0.0, None),
    ])  # fmt: skip


def search(motion: Motion, e: float, s0: float, offset: float) -> NearestPair:
    follower = TranslatingRoller(roller_radius_mm=abs(offset), offset_mm=e)
    return nearest_far_pair(
        OffsetProfile(PiecewiseMotion(motion), lambda s: follower.position(s, (e, s0)), offset)
    )


def agree(motion: Motion, e: float, s0: float, offset: float) -> bool:
    """Search and samples, on yes or no and on the depth; whether the profile crosses itself."""
    radius = abs(offset)
    found, seen = search(motion, e, s0, offset), brute(motion, e, s0, offset)
    crosses = not found.excludes_interference(radius)
    # a sample misses the nearest point by at most half a step along the curve, squared over R
    coarse = 0.5 * seen.step**2 / radius
    if not crosses:
        assert seen.distance >= radius - coarse
        return False
    window = (found.profile_angle, found.roller_angle, 4e-3)
    close = brute(motion, e, s0, offset, window)
    assert found.distance == pytest.approx(close.distance, abs=2e-5 * radius)
    assert found.distance <= seen.distance + 1e-9 * radius
    assert seen.distance <= found.distance + seen.step
    assert found.lower_bound <= found.distance
    assert found.distance - found.lower_bound <= 1e-6 * radius
    return True


@pytest.mark.parametrize("seed", range(40))
def test_agrees_with_brute_force_where_nothing_is_undercut(seed: int) -> None:
    rng = np.random.default_rng(1000 + seed)
    motion, Rp = random_motion(rng), rng.uniform(8.0, 30.0)
    e = Rp * rng.uniform(-0.6, 0.6)
    s0 = math.sqrt(Rp * Rp - e * e)
    agree(motion, e, s0, min(0.96 * sharpest(motion, e, s0), 0.985 * Rp))


def test_brute_force_sees_crossing_and_sound_cams_alike() -> None:
    rng = np.random.default_rng(77)
    reported = []
    for _ in range(12):
        motion, base = thin_lobed(rng), rng.uniform(0.1, 1.7)
        e = rng.uniform(-2.0, 2.0)
        R = min(8.3, (base + 7.0) * 0.97)
        for _ in range(6):  # as large as the lobe's nose allows
            s0 = math.sqrt((base + R) ** 2 - e * e)
            R = min(R, 0.97 * sharpest(motion, e, s0))
        reported.append(agree(motion, e, math.sqrt((base + R) ** 2 - e * e), R))
    assert 3 <= sum(reported) <= 9


@pytest.mark.parametrize(
    ("half_length", "thickness", "offset"),
    [(2.77, 0.31, 0.03), (2.77, 0.31, -0.41), (2.77, 0.31, -0.13),
     (2.31, 0.43, -0.51), (2.31, 0.43, 0.07), (2.93, 0.27, -0.37)],
)  # fmt: skip
def test_any_closed_curve_and_either_side(
    half_length: float, thickness: float, offset: float
) -> None:
    """A horseshoe, which no cam is: an outer profile meets itself in the mouth."""
    shoe = Horseshoe(1.0, half_length, thickness)
    found = nearest_far_pair(OffsetProfile(shoe.motion(), shoe.trace, offset))
    u = 2.0 * np.pi * np.arange(2400) / 2400
    (x, y), (dx, dy) = shoe.point(u)
    speed = np.hypot(dx, dy)
    ox, oy = x + offset * dy / speed, y - offset * dx / speed
    apart = np.hypot(ox[:, None] - x, oy[:, None] - y)
    ahead = (u[None, :] - u[:, None]) % (2.0 * np.pi)
    far = np.minimum(ahead, 2.0 * np.pi - ahead) > 0.9  # past the tips, where it bends sharply
    least = float(np.min(apart[far]))
    assert found.excludes_interference(abs(offset)) == (least >= abs(offset))
    if least < abs(offset):
        assert found.distance == pytest.approx(least, abs=4e-4)  # the samples' step, squared


def thin_lobe(base: float, e: float = 1.3) -> tuple[Motion, Machine, tuple[float, float]]:
    """A roller of 7.6 mm over a lobe whose root is thinner than the roller where base is small."""
    motion = motion_of([
        ("rise", 66.0, 57.0, LAWS["polynomial_4_5_6_7"].curve("rise")),
        ("dwell", 9.0, 0.0, None),
        ("return", 58.0, 57.0, LAWS["cycloidal"].curve("return")),
        ("dwell", 227.0, 0.0, None),
    ])  # fmt: skip
    follower = TranslatingRoller(roller_radius_mm=7.6, offset_mm=e)
    return motion, Machine(follower, 10.0), (e, math.sqrt((base + 7.6) ** 2 - e * e))


def judged(base: float) -> dict[str, Extreme]:
    return on(*thin_lobe(base))


def on(motion: Motion, machine: Machine, size: tuple[float, ...]) -> dict[str, Extreme]:
    return {each.limit: each for each in certify(motion, machine, size, [ProfileRadius()])}


def test_the_certificate_refuses_a_cam_for_crossing_alone() -> None:
    found = judged(0.51)
    assert [name for name, each in found.items() if not each.holds] == ["self_crossing"]
    refused = found["self_crossing"]
    motion, _, (e, s0) = thin_lobe(0.51)
    rough = brute(motion, e, s0, 7.6)
    close = brute(motion, e, s0, 7.6, (rough.profile, rough.roller, 6e-3))
    assert refused.value == pytest.approx(7.6 - close.distance, abs=1e-6)
    assert refused.margin == -refused.value
    assert refused.angle_deg == pytest.approx(math.degrees(close.profile), abs=0.01)
    assert f"at {math.degrees(close.roller):.3g}" in refused.evidence
    assert 0.0 <= refused.width <= 1e-7


def test_the_certificate_accepts_the_same_cam_made_larger() -> None:
    found = judged(0.97)
    assert all(each.holds for each in found.values())
    assert found["self_crossing"].value == 0.0
    assert "the roller reaches into no other part" in found["self_crossing"].evidence


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_size_does_not_matter(scale: float) -> None:
    motion, _, (e, s0) = thin_lobe(0.51)
    small = search(motion, e, s0, 7.6)
    scaled = Motion.of([
        type(s)(s.index, s.kind, s.start, s.angle, scale * s.s_start, scale * s.s_end, s.law)
        for s in motion.segments
    ])  # fmt: skip
    large = search(scaled, scale * e, scale * s0, scale * 7.6)
    assert large.distance == pytest.approx(scale * small.distance, rel=1e-8)
    assert large.profile_angle == pytest.approx(small.profile_angle, abs=1e-4)


def test_a_knife_edge_and_a_flat_face_need_no_search() -> None:
    motion, _, (e, s0) = thin_lobe(3.7)
    edge = Machine(TranslatingRoller(roller_radius_mm=0.0, offset_mm=e), 10.0)
    found = {each.limit: each for each in certify(motion, edge, (e, s0), [])}
    assert found["self_crossing"].holds
    assert "monotone in s" in found["self_crossing"].evidence
    # below the axis it comes nearer as s grows
    below = {each.limit: each for each in certify(motion, edge, (e, -90.0), [])}
    assert below["self_crossing"].holds
    # through the axis the point comes back over places that it has passed before
    under = {each.limit: each for each in certify(motion, edge, (e, -20.0), [])}
    assert not under["self_crossing"].holds
    there = math.radians(under["self_crossing"].angle_deg)
    (s,) = motion.derivatives([there, there + 0.05], 0)
    assert min(s) <= 20.0 <= max(s)  # there it is nearest to the axis
    face = certify(motion, Machine(TranslatingFlatFace(), 10.0), (300.0,), [])
    assert "self_crossing" not in {each.limit for each in face}


def test_a_corner_that_turns_away_is_no_crossing() -> None:
    """Constant velocity: the profile rounds the hollow corner along the roller itself."""
    line = LAWS["constant_velocity"]
    motion = motion_of([
        ("return", 130.0, 27.0, line.curve("return")), ("dwell", 71.0, 0.0, None),
        ("rise", 97.0, 27.0, line.curve("rise")), ("dwell", 62.0, 0.0, None),
    ])  # fmt: skip
    assert search(motion, 3.1, 41.7, 1e-3).excludes_interference(1e-3)


def test_normals_say_nothing_of_a_curve_with_a_corner(monkeypatch: pytest.MonkeyPatch) -> None:
    """Even where all of them point away from the axis: what they do at the corner is not seen."""
    monkeypatch.setattr(certificate, "clear_flanks", lambda flanks, _: flanks)
    line = LAWS["constant_velocity"]
    motion = motion_of([
        ("rise", 31.0, 57.0, line.curve("rise")), ("dwell", 5.0, 0.0, None),
        ("return", 33.0, 57.0, line.curve("return")), ("dwell", 291.0, 0.0, None),
    ])  # fmt: skip
    machine = Machine(TranslatingRoller(roller_radius_mm=7.6, offset_mm=1.3), 10.0)
    assert not on(motion, machine, (1.3, 7.0))["self_crossing"].holds
    smooth, machine, size = thin_lobe(0.51)
    assert on(smooth, machine, size)["self_crossing"].holds


def test_what_cannot_be_proven_is_not_called_sound() -> None:
    """A roller whose centre runs through the cam's axis with the offset 0: no tangent there."""
    motion, _, _ = thin_lobe(1.0)
    assert not search(motion, 0.0, 0.0, 2.0).excludes_interference(2.0)


def test_every_flank_is_judged_by_itself() -> None:
    """A groove over the thin lobe: its inner flank crosses itself, its outer one does not."""
    motion, machine, size = thin_lobe(0.51)
    groove = machine.follower.model_copy(update={"closure": Groove()})
    found = on(motion, Machine(groove, 10.0), size)
    alone = judged(0.51)["self_crossing"]
    assert found["self_crossing_inner"].value == alone.value
    assert not found["self_crossing_inner"].holds
    assert found["self_crossing_outer"].holds


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_roller_and_its_profile_point_lie_in_the_shadow(side: float) -> None:
    """Seen from the axis, on every box; a roller that covers the axis fills the whole turn."""
    rng = np.random.default_rng(31)
    motion, R = thin_lobed(rng), 8.3
    e, s0 = 1.7, math.sqrt((0.9 + R) ** 2 - 1.7**2)
    follower = TranslatingRoller(roller_radius_mm=R, offset_mm=e)
    path = OffsetProfile(PiecewiseMotion(motion), lambda s: follower.position(s, (e, s0)), side * R)
    intervals = path.motion.intervals(0.13)
    low, high = path.models(intervals).polar_range()
    share = np.linspace(0.0, 1.0, 9)
    theta = (intervals.lo[:, None] + (intervals.hi - intervals.lo)[:, None] * share).ravel()
    s, v = motion.derivatives(theta, 1)
    x, y, tx, ty = np.full_like(s, e), s0 + s, s0 + s, v - e
    rim = R * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 60))
    roller = (x + 1j * y)[:, None] + rim
    touched = x + 1j * y - side * R * (-ty + 1j * tx) / np.hypot(tx, ty)
    points = np.column_stack([roller, touched]) * np.exp(-1j * theta)[:, None]
    middle, half = (np.repeat(v, len(share))[:, None] for v in (0.5 * (low + high), high - low))
    off = np.abs(np.angle(points * np.exp(-1j * middle)))
    assert np.all(off <= 0.5 * half + 1e-12)
    filled = np.max(off, axis=1) / (0.5 * half[:, 0])
    assert np.max(filled) > 0.999  # no wider than need be
    low, high = OffsetProfile(path.motion, path.trace, side * 40.0).models(intervals).polar_range()
    assert np.any(high - low == 2.0 * np.pi)
    assert np.any(high - low < 5.0)


def test_the_certificate_needs_no_pairs_where_curves_go_round_the_axis() -> None:
    """What its own boxes say of n · P: against samples, and the search that knows nothing of it."""
    rng, reported = np.random.default_rng(58), []
    theta = np.linspace(0.0, 2.0 * np.pi, 4001)
    for _ in range(24):
        motion, R = thin_lobed(rng), rng.uniform(2.0, 9.0)
        e, s0 = size = rng.uniform(-2.0, 2.0), R * rng.uniform(0.4, 9.0)
        follower = TranslatingRoller(roller_radius_mm=R, offset_mm=e, closure=Groove())
        machine = Machine(follower, 10.0)
        cam = MeasuredCam.of(motion, machine, size)
        flanks, questions, subjects = roller_clearances(cam, 0)
        answers = cam.enclose(subjects, questions)
        clear = clear_flanks(flanks, answers)
        found = on(motion, machine, size)
        along = pitch(motion, e, s0, theta + 1e-6) - pitch(motion, e, s0, theta - 1e-6)
        here = pitch(motion, e, s0, theta)
        moment = here[:, 1] * along[:, 0] - here[:, 0] * along[:, 1]
        speed = np.hypot(*along.T)
        for flank, answer in zip(flanks, answers, strict=True):
            offset = flank.side * flank.distance
            over = float(np.min(moment - max(offset, 0.0) * speed)) / 2e-6
            assert answer.enclosure.lower <= over + 1e-3
            assert over > 0.0 or flank not in clear
            holds = search(motion, e, s0, offset).excludes_interference(flank.distance)
            assert found[f"self_crossing_{flank.name}"].holds == holds
        reported.append(len(clear))
    assert set(reported) == {0, 1, 2}
