"""Branch and bound on functions whose extremes are known."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from synthesis.numerics.enclosure import MOST_BOXES, ExtremumQuery, enclose
from synthesis.numerics.piecewise import Piecewise
from synthesis.numerics.taylor import Jets, Taylor


def wave(frequency: float, phase: float = 0.3):
    """sin(frequency · x + phase) as a model."""

    return waves((frequency, phase))


def waves(*terms: tuple[float, float]):
    """sin(frequency · x + phase) of every pair as models."""

    def models(piece, lo, hi, wanted):
        centre, r = 0.5 * (lo + hi), 0.5 * (hi - lo) + 1e-15
        zero = np.zeros_like(r)
        return [
            np.sin(Taylor.of(frequency * centre + phase, frequency * r, zero, zero))
            for frequency, phase in (terms[k] for k in wanted)
        ]

    return models


BREAKS = np.array([0.0, 1.0, 2.5, 3.0])
COUNTS = np.array([3, 5, 1])
EVERYWHERE = np.arange(3)


def test_a_maximum_and_a_minimum_are_enclosed():
    upper = ExtremumQuery(EVERYWHERE, -math.inf, 0.2)
    lower = ExtremumQuery(EVERYWHERE, -2.0, math.inf)
    top, bottom = enclose(wave(2.0), BREAKS, COUNTS, [upper, lower])
    assert (top.side, bottom.side) == (1, -1)
    assert top.enclosure.lower <= 1.0 <= top.enclosure.upper
    assert bottom.enclosure.lower <= -1.0 <= bottom.enclosure.upper
    assert top.enclosure.width < 1e-10
    assert bottom.enclosure.width < 2.1e-10
    assert 2.0 * top.enclosure.angle + 0.3 == pytest.approx(math.pi / 2, abs=1e-7)
    assert 2.0 * bottom.enclosure.angle + 0.3 == pytest.approx(1.5 * math.pi, abs=1e-7)


def test_the_nearer_bound_is_reported():
    (answer,) = enclose(wave(2.0), BREAKS, COUNTS, [ExtremumQuery(EVERYWHERE, -1.1, 1.2)])
    assert answer.side == -1
    assert answer.enclosure.value == pytest.approx(-1.0, abs=1e-12)


def test_only_the_pieces_asked_for_count():
    (answer,) = enclose(wave(1.0, 0.0), BREAKS, COUNTS, [ExtremumQuery(np.array([2]), 0.0, 0.0)])
    assert answer.enclosure.value == pytest.approx(math.sin(2.5), abs=1e-13)
    assert answer.enclosure.angle == 2.5


def test_many_equal_peaks_are_all_excluded():
    (answer,) = enclose(wave(120.0), BREAKS, COUNTS, [ExtremumQuery(EVERYWHERE, 0.0, 0.0)])
    assert answer.enclosure.width < 1e-9
    assert answer.enclosure.lower <= answer.side <= answer.enclosure.upper


def test_questions_about_several_functions_do_not_disturb_each_other():
    """Asked together or one by one: the same extremes, each within what is true of it."""
    terms = (2.0, 0.3), (120.0, 0.1), (9.0, -1.7)
    part = np.array([[0.2, 0.7], [1.3, 2.1]])
    questions = [
        ExtremumQuery(EVERYWHERE, -1.3, 1.2, function=1),
        ExtremumQuery(np.array([0, 2]), -math.inf, 0.9, function=0),
        ExtremumQuery(np.array([0, 1]), -0.4, math.inf, spans=part, function=2, relative=1e-14),
        ExtremumQuery(np.array([2]), -math.inf, 3.0, function=1, absolute=1e-3),
    ]
    together = enclose(waves(*terms), BREAKS, COUNTS, questions)
    x = np.linspace(0.0, 3.0, 3_000_01)
    for question, answer in zip(questions, together, strict=True):
        (alone,) = enclose(waves(*terms), BREAKS, COUNTS, [question])
        assert answer.side == alone.side
        width = answer.enclosure.width + alone.enclosure.width
        assert answer.enclosure.value == pytest.approx(alone.enclosure.value, abs=width)
        assert answer.enclosure.width < (2e-3 if question.absolute else 3e-10)
        spans = question.spans
        if spans is None:
            spans = np.stack([BREAKS[question.pieces], BREAKS[question.pieces + 1]], axis=1)
        frequency, phase = terms[question.function]
        inside = np.any([(low <= x) & (x <= high) for low, high in spans], axis=0)
        reached = answer.side * np.sin(frequency * x[inside] + phase)
        found = (answer.side * answer.enclosure.lower, answer.side * answer.enclosure.upper)
        assert max(reached) <= max(found) + 1e-15
        assert max(reached) == pytest.approx(max(found), abs=1e-6 + question.absolute)


def test_what_is_good_enough_of_a_function_goes_for_every_question_about_it():
    """Beside the questions or in them: it is the same, and it saves boxes."""
    terms, enough = ((2.0, 0.3), (9.0, -1.7)), (0.0, 3e-3)
    plain = [ExtremumQuery(EVERYWHERE, -1.3, math.inf, function=k) for k in (1, 0, 1)]
    own = [replace(question, absolute=enough[question.function]) for question in plain]
    beside = enclose(waves(*terms), BREAKS, COUNTS, plain, enough=enough)
    assert beside == enclose(waves(*terms), BREAKS, COUNTS, own)
    exact = enclose(waves(*terms), BREAKS, COUNTS, plain)
    assert beside[0].boxes < exact[0].boxes
    assert 1e-9 < beside[0].enclosure.width <= 3e-3 + 1e-9


@pytest.mark.parametrize("sees", [False, True])
def test_a_bound_alone_is_asked_of_the_first_boxes(sees: bool):
    """No box is split for it, what it says is true, and the other questions hear nothing of it."""
    values = reported if sees else None
    alone = enclose(waves(*TERMS), BREAKS, COUNTS, ASKED, values)
    rough = ExtremumQuery(EVERYWHERE, 0.2, math.inf, function=0, absolute=math.inf)
    high = ExtremumQuery(np.array([1]), -math.inf, 0.2, function=0, absolute=math.inf)
    *others, low, top = enclose(waves(*TERMS), BREAKS, COUNTS, [*ASKED, rough, high], values)
    for one, other in zip(alone, others, strict=True):
        assert other.enclosure.value == pytest.approx(one.enclosure.value, abs=3e-10)
        assert other.enclosure.width < 3e-10
    assert -1.0 - 0.1 < low.enclosure.lower <= -1.0
    (lone,) = enclose(waves(*TERMS), BREAKS, COUNTS, [rough], values)
    assert -1.0 - 0.1 < lone.enclosure.lower <= -1.0
    assert lone.boxes == COUNTS.sum()
    largest = np.max(np.sin(2.0 * np.linspace(1.0, 2.5, 30_001) + 0.3))
    assert largest <= top.enclosure.upper < largest + 0.1


TERMS = (2.0, 0.3), (3.3, 0.1), (9.0, -1.7)
ASKED = [
    ExtremumQuery(EVERYWHERE, -1.3, 1.2, function=1),
    ExtremumQuery(np.array([0, 2]), -math.inf, 0.9, function=0),
    ExtremumQuery(
        np.array([0, 1]), -0.4, math.inf, spans=np.array([[0.2, 0.7], [1.3, 2.1]]), function=2
    ),
]  # fmt: skip


def reported(piece, x, wanted):
    """The functions of TERMS in numbers."""
    return [np.sin(frequency * x + phase) for frequency, phase in (TERMS[k] for k in wanted)]


def test_a_look_at_the_numbers_saves_rounds():
    blind = enclose(waves(*TERMS), BREAKS, COUNTS, ASKED)
    seeing = enclose(waves(*TERMS), BREAKS, COUNTS, ASKED, reported)
    for one, other in zip(blind, seeing, strict=True):
        assert other.side == one.side
        assert other.enclosure.value == pytest.approx(one.enclosure.value, abs=1e-10)
        assert other.enclosure.width < 3e-10
    assert sum(answer.boxes for answer in seeing) < 0.5 * sum(answer.boxes for answer in blind)


@pytest.mark.parametrize(
    "lie",
    [lambda v: -v, lambda v: np.full_like(v, np.nan), lambda v: 0.0 * v, lambda v: np.inf * v],
)
def test_numbers_that_lie_cost_time_and_nothing_else(lie):
    answers = enclose(
        waves(*TERMS), BREAKS, COUNTS, ASKED, lambda *request: [lie(v) for v in reported(*request)]
    )
    for answer, true in zip(answers, enclose(waves(*TERMS), BREAKS, COUNTS, ASKED), strict=True):
        assert answer.side == true.side
        assert answer.enclosure.lower <= true.enclosure.upper
        assert answer.enclosure.upper >= true.enclosure.lower
        assert answer.enclosure.width < 3e-10


def test_no_point_is_taken_from_where_a_question_does_not_ask():
    """In numbers nothing is known of the piece asked for, and much of others."""

    def elsewhere(piece, x, wanted):
        return [np.where(piece == 2, np.nan, v) for v in reported(piece, x, wanted)]

    questions = [ExtremumQuery(np.array([k]), -math.inf, 0.0) for k in (2, 0)]
    answer, _ = enclose(waves(*TERMS), BREAKS, COUNTS, questions, elsewhere)
    assert 2.5 <= answer.enclosure.angle <= 3.0
    assert answer.enclosure.value == pytest.approx(math.sin(6.3), abs=1e-12)  # at its right end
    assert answer.enclosure.width < 3e-10


def test_what_roundings_leave_open_is_not_cut_on_and_on():
    """A value that is known to 1e-9 only, on an arc where it hardly changes."""

    def models(piece, lo, hi, wanted):
        centre, r = 0.5 * (lo + hi), 0.5 * (hi - lo)
        zero = np.zeros_like(r)
        x = Taylor.of(1e-7 * centre, 1e-7 * r, zero, zero)
        square = x * x
        return [Taylor(1.0 - square.c0, square.c1, square.c2, square.rem + 1e-9, square.mag + 1.0)]

    (answer,) = enclose(models, BREAKS, COUNTS, [ExtremumQuery(EVERYWHERE, -math.inf, 2.0)])
    assert answer.boxes < 1000
    assert 2e-9 <= answer.enclosure.width < 4e-9


def test_a_pole_is_reported_as_unknown():
    def model(piece, lo, hi, wanted):
        centre, r = 0.5 * (lo + hi), 0.5 * (hi - lo)
        zero = np.zeros_like(r)
        return [1.0 / Taylor.of(centre - 1.234, r, zero, zero)]

    (answer,) = enclose(model, BREAKS, COUNTS, [ExtremumQuery(EVERYWHERE, -math.inf, 7.0)])
    assert answer.enclosure.upper == math.inf
    assert answer.boxes <= MOST_BOXES


def test_nothing_but_nan_is_unknown():
    def model(piece, lo, hi, wanted):
        bad = np.full_like(lo, np.nan)
        return [Taylor(bad, bad, bad, bad, bad)]

    (answer,) = enclose(model, BREAKS, COUNTS, [ExtremumQuery(EVERYWHERE, -1.0, 1.0)])
    assert math.isnan(answer.enclosure.value)
    assert answer.enclosure.upper == math.inf
    assert answer.boxes <= MOST_BOXES


@pytest.mark.parametrize("side", [-1, 1])
def test_when_boxes_run_out_the_width_is_honest(monkeypatch, side):
    monkeypatch.setattr("synthesis.numerics.enclosure.MOST_BOXES", 40)
    bounds = (-math.inf, 3.0) if side > 0 else (-3.0, math.inf)
    (answer,) = enclose(wave(9.0), BREAKS, COUNTS, [ExtremumQuery(EVERYWHERE, *bounds)])
    assert answer.side == side
    assert answer.enclosure.width > 1e-6
    assert answer.enclosure.value == pytest.approx(math.sin(9.0 * answer.enclosure.angle + 0.3))
    # the end that is reached is a value of the function; the other is beyond all of them
    reached, proven = answer.enclosure.lower, answer.enclosure.upper
    if side < 0:
        reached, proven = -proven, -reached
    assert reached <= 1.0 < proven


def test_when_rounds_run_out_the_width_is_honest(monkeypatch):
    monkeypatch.setattr("synthesis.numerics.enclosure.MOST_LEVELS", 2)
    (answer,) = enclose(wave(33.0), BREAKS, COUNTS, [ExtremumQuery(EVERYWHERE, -math.inf, 1.0)])
    assert answer.enclosure.lower <= 1.0 < answer.enclosure.upper
    assert answer.enclosure.width > 1e-9


def test_what_is_reached_is_reached_inside() -> None:
    """Models look a little over the ends of their boxes: on a steep slope that must not count."""
    rng = np.random.default_rng(5)
    for _ in range(40):
        slope, start, width = (float(x) for x in rng.uniform([1e3, 3.0, 0.1], [1e5, 6.0, 0.7]))
        line = Piecewise.of([start, start + width], [[1.0, slope]])
        jets = Jets(line)
        (answer,) = enclose(
            lambda piece, lo, hi, wanted, jets=jets: jets.models(piece, lo, hi, 0),
            line.breaks, np.array([3]), [ExtremumQuery(np.array([0]), -math.inf, 0.0)],
        )  # fmt: skip
        low, high = Fraction(float(line.breaks[0])), Fraction(float(line.breaks[1]))
        top = 1 + Fraction(slope) * (high - low)
        assert Fraction(answer.enclosure.lower) <= top <= Fraction(answer.enclosure.upper)


@pytest.mark.parametrize("bounds", [(-math.inf, 1e9), (-1e9, math.inf), (-1e9, 1e9)])
def test_a_far_bound_costs_the_enclosure_no_truth(bounds) -> None:
    """The extreme is enclosed though its distance to the bound has lost its last digits."""
    rng = np.random.default_rng(9)
    for _ in range(40):
        top, bend = (float(x) for x in rng.uniform([1.0, 0.1], [2.0, 3.0]))
        hill = Piecewise.of([0.0, 1.0], [[top, 0.0, -bend]], origins=[0.5])
        jets = Jets(hill)
        (answer,) = enclose(
            lambda piece, lo, hi, wanted, jets=jets: jets.models(piece, lo, hi, 0),
            hill.breaks, np.array([3]), [ExtremumQuery(np.array([0]), *bounds)],
        )  # fmt: skip
        truth = top if answer.side > 0 else Fraction(top) - Fraction(bend) / 4
        found = answer.enclosure
        assert Fraction(found.lower) <= truth <= Fraction(found.upper)
        assert found.width <= (3e-6 if math.isfinite(sum(bounds)) else 1e-1)
