"""What the search for far parts of a profile says of its own parts, and when its budget ends."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from synthesis.catalogue.followers import TranslatingRoller
from synthesis.certify import roller_interference
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.certify.roller_interference import OffsetProfile, ProfileModels, ThickChords, _range
from synthesis.numerics.box_search import Boxes
from synthesis.numerics.taylor import Taylor
from tests.certify.crossing import brute
from tests.certify.test_self_crossing import search, thin_lobe

SHARE = np.linspace(-1.0, 1.0, 41)


def models(seed: int, count: int = 200) -> Taylor:
    """Models of any shape, with a remainder as large as the rest."""
    c0, c1, c2, rem = np.random.default_rng(seed).uniform(-1.0, 1.0, (4, count))
    return Taylor.of(c0, c1, c2, np.abs(rem))


def values(model: Taylor) -> np.ndarray:
    """What the model stands for at most and at least, at 41 places of every box."""
    parabola = model.c0 + np.outer(SHARE, model.c1) + np.outer(SHARE**2, model.c2)
    return np.concatenate([parabola - model.rem, parabola + model.rem])


def test_the_range_of_an_angle_holds_all_that_its_model_stands_for() -> None:
    angle = models(1)
    low, high = _range(angle)
    assert np.all(low <= values(angle).min(axis=0) + 1e-15)
    assert np.all(high >= values(angle).max(axis=0) - 1e-15)


def test_the_cam_angle_s_model_holds_both_ends_of_its_interval() -> None:
    ends = np.sort(np.random.default_rng(4).uniform(0.0, 6.28, (2, 300)), axis=0)
    piece = np.zeros(300, dtype=int)
    boxes = Boxes.from_spans(piece, ends[0], ends[1], piece + 1)
    theta = ProfileModels(boxes, (0.0, 0.0), (0.0, 0.0), 0.0).theta
    for lo, hi, c0, c1, rem in zip(*ends, theta.c0, theta.c1, theta.rem, strict=True):
        middle, half, error = (Fraction(float(x)) for x in (c0, c1, rem))
        assert middle - half - error <= Fraction(float(lo)) <= middle - half + error
        assert middle + half - error <= Fraction(float(hi)) <= middle + half + error
        assert error < 1e-13


def test_chords_are_as_thick_as_the_curves_are_apart_from_them() -> None:
    x, y = models(2), models(3)
    chords = ThickChords.of(x, y)
    ends = [chords.middle - chords.half, chords.middle + chords.half]
    along = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    off = np.stack([values(x), values(y)]) - ends[0][:, None]
    beside = np.abs(off[0] * along[1] - off[1] * along[0])
    assert np.all(beside <= chords.thickness)
    assert np.max(beside / chords.thickness) > 0.9
    assert np.all(np.hypot(x.rem, y.rem) <= chords.error)


def test_a_chord_of_a_parabola_is_no_thicker_than_half_its_bend() -> None:
    nothing, one = np.zeros(1), np.ones(1)
    chords = ThickChords.of(
        Taylor.of(nothing, one, nothing, nothing), Taylor.of(nothing, nothing, one, nothing)
    )
    height = chords.middle[1] - SHARE**2  # of the chord over the parabola (t, t²)
    assert chords.thickness == pytest.approx(np.max(np.abs(height)))


def roller_path(base: float) -> OffsetProfile:
    motion, machine, size = thin_lobe(base)
    assert isinstance(machine.follower, TranslatingRoller)
    trace = machine.follower.position
    return OffsetProfile(PiecewiseMotion(motion), lambda s: trace(s, size), 7.6)


@pytest.mark.parametrize(("base", "sound"), [(0.97, True), (0.51, False)])
def test_a_search_without_time_proves_no_more_than_it_saw(
    base: float, sound: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = roller_path(base)
    whole = roller_interference.nearest_far_pair(path)
    assert whole.excludes_interference(7.6) == sound
    monkeypatch.setattr(roller_interference, "MAX_LEVELS", 1)
    first = roller_interference.nearest_far_pair(path)
    assert not first.excludes_interference(7.6)
    assert first.lower_bound < min(whole.lower_bound, 7.6 * (1.0 - 1e-3))
    assert 0 < first.pairs < whole.pairs
    # the distance said is that of the places said, though these are only centres of wide boxes
    motion, _, (e, s0) = thin_lobe(base)
    there = brute(motion, e, s0, 7.6, (first.profile_angle, first.roller_angle, 0.0))
    assert 0.0 <= first.distance - there.distance < 0.15  # an upper bound


def test_a_place_without_a_tangent_ends_the_search_and_is_named() -> None:
    motion, _, _ = thin_lobe(1.0)
    found = search(motion, 0.0, 0.0, 2.0)  # the centre rests on the axis in the dwell of 227°
    assert (found.distance, found.lower_bound, found.pairs) == (math.inf, 0.0, 0)
    assert found.profile_angle == 0.0 or found.profile_angle >= math.radians(133.0) - 1e-9
