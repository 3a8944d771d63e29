"""What every law in the registry has to satisfy; a new law is tested by being named."""

from typing import Literal, cast

import numpy as np
import pytest

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.laws.base import characteristics, extremes
from synthesis.catalogue.motion import Motion
from synthesis.spec.program import Dwell, Return, Rise
from synthesis.units import CORE_UNITS

KINDS = sorted(LAWS)
REST = [kind for kind in KINDS if LAWS[kind].ends == "R-R"]
TURN = [kind for kind in KINDS if LAWS[kind].ends == "R-U"]
DENSE = np.linspace(0.0, 1.0, 4001)
SEGMENTS: tuple[Literal["rise", "return"], ...] = ("rise", "return")

every_law = pytest.mark.parametrize("kind", KINDS)
both_ways = pytest.mark.parametrize("segment", SEGMENTS)


def test_every_law_says_where_it_ends() -> None:
    assert sorted(REST + TURN) == KINDS
    assert TURN == ["double_harmonic", "kloomok_muffley_8", "polynomial_3_4_5_6"]


@every_law
def test_named_and_sourced(kind: str) -> None:
    law = LAWS[kind]
    assert law.kind == kind
    assert law.entry.title
    assert law.entry.source
    assert law.free_law() is None
    assert [other.entry.title for other in LAWS.values()].count(law.entry.title) == 1


@every_law
@both_ways
def test_runs_from_0_to_1_and_never_back(kind: str, segment: Literal["rise", "return"]) -> None:
    curve = LAWS[kind].curve(segment)
    assert curve.breaks[0] == 0.0
    assert curve.breaks[-1] == 1.0
    assert np.all(np.diff(curve.breaks) > 0.0)
    assert abs(curve(0.0)) <= 1e-16
    assert abs(curve(1.0) - 1.0) <= 2.3e-16
    s, v = curve.derivatives(DENSE, 1)
    assert s.min() >= -1e-16
    assert s.max() <= 1.0 + 2.3e-16
    assert v.min() >= -1e-14


@every_law
def test_ends_as_it_says(kind: str) -> None:
    law, peak = LAWS[kind], characteristics(LAWS[kind])
    start, end = law.curve("rise").derivatives([0.0, 1.0]).T
    if kind != "constant_velocity":
        assert np.abs([start[1], end[1]]).max() <= 1e-14
    if None not in (peak.Cj_max, peak.Cj_min):
        assert abs(start[2]) <= 1e-13
        assert abs(end[2]) <= 1e-13 or law.ends == "R-U"
    if law.ends == "R-U":
        assert end[2] < -1.0


@pytest.mark.parametrize(
    ("kind", "zeros"),
    [("polynomial_4_5_6_7", 3), ("polynomial_5_6_7_8_9", 4), ("polynomial_6_7_8_9_10_11", 5),
     ("peisakh_11", 4), ("cv50_haversine", 3)],
)  # fmt: skip
def test_smooth_laws_leave_and_arrive_smoothly(kind: str, zeros: int) -> None:
    ends = LAWS[kind].curve("rise").derivatives([0.0, 1.0], zeros)
    assert np.abs(ends[1:]).max() <= 1e-12
    assert np.all(ends[0] == [0.0, 1.0])


@every_law
@both_ways
def test_pieces_meet(kind: str, segment: Literal["rise", "return"]) -> None:
    curve, peak = LAWS[kind].curve(segment), characteristics(LAWS[kind])
    inner = curve.breaks[1:-1]
    jump = np.abs(curve.derivatives(inner, 2, "left") - curve.derivatives(inner, 2, "right"))
    assert jump[:2].max(initial=0.0) <= 1e-14
    if kind != "parabolic":
        assert jump[2].max(initial=0.0) <= 1e-13 * (peak.Ca_max or 1.0)


@every_law
@both_ways
@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_match_differences(
    kind: str, segment: Literal["rise", "return"], order: int
) -> None:
    """Eighth-order central differences of the derivative before, inside each piece."""
    curve = LAWS[kind].curve(segment)
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    for low, high in zip(curve.breaks[:-1], curve.breaks[1:], strict=True):
        h = (high - low) / 250
        x = low + (high - low) * np.array([0.0567, 0.234567, 0.51, 0.789, 0.9432])
        step = sum(w * curve(x + k * h, order - 1) for k, w in zip(range(-4, 5), weights))  # noqa: B905
        peak = max(abs(value) for value in extremes(curve, order))
        assert np.abs(step / h - curve(x, order)).max() <= 3e-11 * max(peak, 1.0)


@pytest.mark.parametrize("kind", REST)
def test_symmetric_about_the_middle(kind: str) -> None:
    curve = LAWS[kind].curve("rise")
    x = np.array([0.0123, 0.0987, 0.1234567, 0.2345, 0.3141593, 0.4567, 0.49])
    before, after = curve.derivatives(x), curve.derivatives(1.0 - x)
    assert np.abs(after[0] - (1.0 - before[0])).max() <= 4e-16
    for order, sign in ((1, 1.0), (2, -1.0), (3, 1.0)):
        peak = max(np.abs(before[order]).max(), 1.0)
        assert np.abs(after[order] - sign * before[order]).max() <= 1e-12 * peak
    assert abs(curve(0.5) - 0.5) <= 1e-16


@pytest.mark.parametrize("kind", REST)
def test_a_return_runs_like_a_rise(kind: str) -> None:
    assert LAWS[kind].curve("return") is LAWS[kind].curve("rise")


@pytest.mark.parametrize("kind", TURN)
def test_the_turn_is_at_the_top_unless_asked_for_at_the_bottom(kind: str) -> None:
    law = LAWS[kind]
    low = law.model_copy(update={"turn": "bottom"})
    x = np.array([0.0123, 0.1234567, 0.3141593, 0.5, 0.6543, 0.9])
    rise, fall = law.curve("rise")(x), law.curve("return")(1.0 - x)
    assert np.abs(fall - (1.0 - rise)).max() <= 3e-16
    assert np.array_equal(low.curve("rise")(x), law.curve("return")(x))
    assert np.array_equal(low.curve("return")(x), rise)
    assert low.ends == "U-R"
    mirror, peak = characteristics(low), characteristics(law)
    assert mirror.Ca_max == pytest.approx(-cast(float, peak.Ca_min), rel=1e-12)
    assert mirror.Cj_max == pytest.approx(peak.Cj_max, rel=1e-12)
    assert mirror.Cj_min == pytest.approx(peak.Cj_min, rel=1e-12)


@every_law
def test_peaks_bound_a_dense_sampling_and_are_reached(kind: str) -> None:
    curve = LAWS[kind].curve("rise")
    for order in (1, 2, 3):
        top, bottom = extremes(curve, order)
        values = np.concatenate([curve(DENSE, order, "left"), curve(DENSE, order, "right")])
        scale = max(abs(top), abs(bottom), 1.0)
        assert -1e-12 * scale <= top - values.max() <= 1e-5 * scale
        assert -1e-12 * scale <= values.min() - bottom <= 1e-5 * scale


@every_law
def test_joins_dwells(kind: str) -> None:
    """s, and as many derivatives as stay finite, are continuous where a move meets a dwell."""
    law, peak = LAWS[kind], characteristics(LAWS[kind])
    program = [
        Dwell(angle_deg=37.0),
        Rise(angle_deg=71.0, lift_mm=23.4, law=law),
        Dwell(angle_deg=11.0),
        Return(angle_deg=83.0, lift_mm=23.4, law=law),
        Dwell(angle_deg=158.0),
    ]
    start, s, segments = 0.0, 0.0, []
    for i, segment in enumerate(program):
        angle = np.deg2rad(segment.angle_deg)
        segments.append(segment.place(i, start, angle, s, CORE_UNITS))
        start, s = start + angle, s + segment.signed_lift
    motion = Motion.of(segments)
    joints = np.array([segment.start for segment in segments[1:]])
    left, right = (motion.derivatives(joints, 2, side) for side in ("left", "right"))
    jump = np.abs(left - right)
    if law.ends == "R-U":  # the top ends of both moves meet no dwell
        jump = jump[:, [0, 3]]
    assert jump[0].max() <= 1e-14 * 23.4
    if None not in (peak.Ca_max, peak.Ca_min):
        assert jump[1].max() <= 1e-13 * 23.4
    if None not in (peak.Cj_max, peak.Cj_min):
        assert jump[2].max() <= 1e-12 * 23.4
    else:
        assert jump[1:].max() > 1.0


@pytest.mark.parametrize("kind", TURN)
def test_rise_and_return_meet_at_a_turn(kind: str) -> None:
    law = LAWS[kind]
    angle = 1.1
    up = Rise(angle_deg=63.0, lift_mm=8.5, law=law).place(0, 0.0, angle, 0.0, CORE_UNITS)
    down = Return(angle_deg=63.0, lift_mm=8.5, law=law).place(1, angle, angle, 8.5, CORE_UNITS)
    motion = Motion.of([up, down])
    left, right = (motion.derivatives([angle], 2, side)[:, 0] for side in ("left", "right"))
    assert left == pytest.approx(right, abs=1e-12)
    assert abs(left[1]) <= 1e-14 * 8.5
    assert left[2] < -1.0
