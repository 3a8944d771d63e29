"""Boxes cut at points: they cover what they covered, for whom they did."""

import numpy as np
import pytest

from synthesis.numerics.box_search import Boxes
from synthesis.numerics.maxima import locate_extrema

RNG = np.random.default_rng(8)


def some() -> Boxes:
    """Boxes of two pieces that overlap, and a point."""
    pieces, request = np.array([0, 0, 1, 1]), np.array([[1, 0, 1, 0], [0, 1, 1, 1]], dtype=bool)
    first, last = np.array([0.0, 0.3, 1.1, 1.7]), np.array([1.1, 0.9, 2.3, 1.7])
    return Boxes.from_spans(pieces, first, last, np.array([3, 4]), request)


def test_equal_parts_from_end_to_end() -> None:
    boxes = some()
    assert boxes.lo.tolist()[:4] == [0.0, 1.1 / 3, 2.2 / 3, 0.3]
    np.testing.assert_array_equal(boxes.piece, [0] * 6 + [1] * 5)
    assert (boxes.lo[-1], boxes.hi[-1]) == (1.7, 1.7)
    assert boxes.hi[2] == 1.1


def test_cut_boxes_cover_the_same_for_the_same() -> None:
    boxes = some()
    cuts = np.sort(np.concatenate([RNG.uniform(-0.5, 2.5, 40), [0.3, 1.7]]))
    cut = boxes.cut_at(cuts)
    x = np.concatenate([RNG.uniform(0.0, 2.3, 500), cuts, boxes.lo])
    for piece in (0, 1):
        for question in (0, 1):
            before, after = (
                np.any(
                    (b.lo <= x[:, None]) & (x[:, None] <= b.hi)
                    & (b.piece == piece) & b.active[question], axis=1,
                )
                for b in (boxes, cut)
            )  # fmt: skip
            np.testing.assert_array_equal(before, after)
    inside = (cut.lo[:, None] < cuts) & (cuts < cut.hi[:, None])
    assert not inside.any()
    assert len(cut) > len(boxes) + 40


def test_the_highest_of_several_peaks_is_seen_where_it_is_asked_for() -> None:
    def heights(piece, x):
        hill = 1.0 - (x - 0.4123) ** 2 - (x - 0.4123) ** 3
        other = 1.3 - 3.0 * (x - 1.9271) ** 2
        return np.stack([np.where(x < 1.1, hill, 0.2), np.where(x < 1.1, hill, other)])

    whole = np.ones((2, 2), dtype=bool)
    boxes = Boxes.from_spans(
        np.array([0, 1]), np.array([0.0, 1.1]), np.array([1.1, 2.3]), np.array([5, 7]), whole
    )
    with np.errstate(all="ignore"):
        question, piece, at, cuts = locate_extrema(boxes, heights, np.zeros(2))
    np.testing.assert_array_equal(question, [0, 1])
    np.testing.assert_array_equal(piece, [0, 1])
    np.testing.assert_allclose(at, [0.4123, 1.9271], atol=1e-6)
    assert np.all(np.diff(cuts) > 0.0)
    apart = np.abs(cuts[:, None] - at)
    assert np.max(np.min(apart, axis=0)) < 2e-4


def test_of_equal_peaks_the_first_is_seen_whatever_their_last_digits() -> None:
    for noise in (3e-12 * RNG.uniform(-1.0, 1.0, 3) for _ in range(5)):

        def heights(piece, x, noise=noise):
            even = 0.83 - 0.29 * (x % 1.0 - 0.4123) ** 2
            return (even + noise[piece])[None]

        ends = np.array([0.0, 1.0, 2.0])
        boxes = Boxes.from_spans(
            np.arange(3), ends, ends + 0.97, np.full(3, 4), np.ones((1, 3), dtype=bool)
        )
        with np.errstate(all="ignore"):
            *_, at, _ = locate_extrema(boxes, heights, np.array([0.61]))
        assert at == pytest.approx([0.4123], abs=1e-5)


def test_of_many_peaks_that_are_nothing_the_first_is_seen() -> None:
    ends = np.arange(9.0)
    boxes = Boxes.from_spans(
        np.arange(9), ends, ends + 1.0, np.full(9, 1), np.ones((2, 9), dtype=bool)
    )

    def heights(piece, x):
        hill = -((x - piece - 0.5) ** 2)
        return np.stack([hill, hill - 0.01 * (piece == 0) + 0.02 * (piece == 7)])

    with np.errstate(all="ignore"):
        question, _, at, _ = locate_extrema(boxes, heights, np.zeros(2))
    np.testing.assert_array_equal(question, [0, 1])
    np.testing.assert_allclose(at, [0.5, 7.5], atol=1e-12)


@pytest.mark.parametrize("count", [7, 200])
def test_a_peak_between_the_samples_is_found(count: int) -> None:
    """Of waves that are long and short beside the boxes: few boxes are looked at more closely."""
    boxes = Boxes.from_spans(
        np.array([0]), np.array([0.0]), np.array([1.0]), np.array([count]), np.ones((1, 1), bool)
    )
    short = 0.2 * count

    def heights(piece, x):
        return (np.sin(3.1 * x + 0.4) + 1e-3 * np.cos(short * (x - 0.31)))[None]

    with np.errstate(all="ignore"):
        *_, (at,), _ = locate_extrema(boxes, heights, np.array([2.0]))
    slope = 3.1 * np.cos(3.1 * at + 0.4) - 1e-3 * short * np.sin(short * (at - 0.31))
    assert abs(slope) < 1e-5 * 3.1**2
