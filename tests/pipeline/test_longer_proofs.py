"""Longer proofs bring a value that suffices and an impossible one near: on a known excess."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf, sqrt
from random import Random
from types import SimpleNamespace
from typing import Any, cast

import pytest

from synthesis.pipeline import longer_proofs
from synthesis.pipeline.boundary import Boundary
from synthesis.pipeline.longer_proofs import ACCURACY, Closing, Point, close_in
from synthesis.pipeline.oracle import Oracle, Trial
from synthesis.pipeline.relaxable import Relaxable

REQUEST = 1000.0
ROUGH = 1e-2  # a gap that a proof closes in a second; a hundredth of it takes ten


@dataclass(frozen=True)
class Curve:
    """The excess of the smallest cam over the way from the request: it falls to 0 at ``way``."""

    excess: float
    way: float
    bend: float = 0.0

    def at(self, way: float) -> float:
        left = 1.0 - way / self.way
        return self.excess * left * (1.0 + self.bend * left) / (1.0 + self.bend)


@dataclass(eq=False)
class Questions:
    """Answers as an oracle's; a proof takes the longer, the finer its tolerance.

    Attributes:
        curves: by the number's name. seconds: left to all. part: left to this one.
        asked: names, values, tolerances and whether any cam would do. as_it_stands: values put.
    """

    curves: dict[str, Curve]
    seconds: list[float]
    part: float = inf
    asked: list[tuple[str, float, float, bool]] = field(default_factory=list)
    as_it_stands: list[float] = field(default_factory=list)
    spec: Any = field(default_factory=lambda: SimpleNamespace(proof="auto", tolerance=5e-3))
    open_gap: float = 0.0
    began: float = 0.0
    asking: float = 0.0
    last_program: float = inf
    random: Random = field(default_factory=lambda: Random(7))

    @property
    def left(self) -> float:
        return min(self.seconds[0], self.part - (self.began - self.seconds[0]))

    def is_late(self) -> bool:
        return self.left <= 0.0

    def share(self, parts: float) -> Questions:
        return replace(self, part=self.left / parts, began=self.seconds[0])

    def relaxed(
        self, number: Relaxable, value: float, tolerance: float, *, exactly: bool, enough: float,
        proof: str,
    ) -> Any:  # fmt: skip
        assert proof == "thorough"
        self.asked.append((number.name, value, tolerance, not exactly and not enough))
        assert len(self.asked) < 200
        excess = self.curves[number.name].at(number.direction * (value - REQUEST))
        took = sqrt(ROUGH / min(tolerance, ROUGH))
        gap = tolerance
        if took > self.left:  # it ends with a gap that is wider
            took, gap = self.left, tolerance * (took / max(self.left, 1e-3)) ** 2
        self.seconds[0] -= took
        gap *= 1.0 + min(excess, 0.0)
        part = self.random.uniform(0.0, 0.95)
        return answer(excess, gap, part, enough=None if exactly else enough)

    def ask_as_it_stands(
        self, number: Relaxable, value: float, proof: str, *, cam_only: bool = False
    ) -> Any:
        if cam_only:  # next to the zero such a search finds none, in little time
            return SimpleNamespace(certified=False, excess=None, smallest=None)
        assert proof == "auto"
        self.as_it_stands.append(value)
        took = min(self.asking, self.left)
        self.seconds[0] -= took
        if took < self.asking:
            return SimpleNamespace(certified=False, excess=None, smallest=None)
        return answer(self.curves[number.name].at(number.direction * (value - REQUEST)), 1e-9)

    def is_valid(self, *_: Any) -> bool:
        return True

    def value_on(self, *_: Any) -> tuple[None, str]:
        return None, ""


def answer(excess: float, gap: float, part: float = 0.4, *, enough: float | None = None) -> Any:
    """A trial whose cam and whose bound are a gap apart, if neither decides before.

    ``part``: of the gap, by which the cam is larger than the smallest.
    """
    upper, lower = excess + part * gap, excess - (0.95 - part) * gap
    if lower > 0.0:
        upper, lower = excess + 0.3 * abs(excess), 1e-9
    elif enough is not None and upper <= enough:
        lower = excess - 1.0
    return SimpleNamespace(
        excess=upper, bound_excess=lower, certified=upper <= 0.0, smallest=None, on_time=True,
        proof="proven" if lower > 0.0 else "", attempt=SimpleNamespace(mesh=lambda _: ()),
    )  # fmt: skip


def known(questions: Questions, sense: str = "≤") -> list[Boundary]:
    """What earlier steps have found of every number: a value far from the least that suffices."""
    boundaries = []
    for name, curve in questions.curves.items():
        number = Relaxable(name, (f"limits/0/{name}",), (REQUEST,), "mm/s³", sense)
        request = answer(curve.excess, 1e-9)
        boundary = Boundary(cast(Oracle, questions), number, cast(Trial, request))
        far = REQUEST + number.direction * 1.15 * curve.way
        boundary.record(far, cast(Trial, answer(curve.at(1.15 * curve.way), 1e-9)))
        boundary.needed = boundary.confirmed = far
        assert boundary.excluded == REQUEST
        boundaries.append(boundary)
    return boundaries


def shares(questions: Questions, boundaries: list[Boundary]) -> list[float]:
    """How far the two values of each are apart; each is on its side of the zero."""
    apart = []
    for boundary in boundaries:
        zero = questions.curves[boundary.number.name].way
        assert boundary.needed is not None
        assert boundary.excluded is not None
        good, bad = boundary.way_to(boundary.needed), boundary.way_to(boundary.excluded)
        assert bad < zero <= good
        apart.append((good - bad) / good)
    return apart


def closed(curves: dict[str, Curve], seconds: float, sense: str = "≤") -> tuple[list[float], int]:
    """How far the two values of each number are apart at the end; the most trials of one search.

    Of some searches, whose cams are larger than the smallest by other parts of the gap.
    """
    apart, most = list[float](), 0
    for seed in range(30):
        questions = Questions(curves, [seconds], random=Random(seed))
        boundaries = known(questions, sense)
        close_in(cast(Oracle, questions), boundaries)
        apart += shares(questions, boundaries)
        most = max(most, len(questions.asked))
    return apart, most


SHAPES = [(0.0037, 211.0, 0.0), (0.0123, 83.0, 0.7), (0.031, 211.0, -0.4), (0.0061, 57.0, 2.0)]


def pair(excess: float, way: float, bend: float) -> dict[str, Curve]:
    return {"a": Curve(excess, way, bend), "b": Curve(0.4 * excess, 0.7 * way, bend)}


@pytest.mark.parametrize("sense", ["≤", "≥"])
@pytest.mark.parametrize("shape", SHAPES)
def test_both_come_near_on_every_curve(shape: tuple[float, float, float], sense: str) -> None:
    apart, most = closed(pair(*shape), 1e6, sense)
    assert max(apart) <= ACCURACY
    assert most <= 30


def test_an_excess_that_falls_ever_more_slowly_takes_longer() -> None:
    """Its slope at the request is seven times that at its zero."""
    apart, most = closed(pair(0.0061, 57.0, 6.0), 1e6)
    assert max(apart) <= ACCURACY
    assert most <= 60


@pytest.mark.parametrize(
    ("seconds", "mean", "near"), [(21.0, 0.43, 0.0), (252.0, 0.07, 0.4), (500.0, 0.02, 0.82)]
)
def test_little_time_brings_them_as_near_as_it_goes(
    seconds: float, mean: float, near: float
) -> None:
    """The accuracy takes minutes; rough proofs, of values farther away, come first."""
    apart = [share for shape in SHAPES for share in closed(pair(*shape), seconds)[0]]
    assert sum(apart) <= mean * len(apart)
    assert sum(share <= ACCURACY for share in apart) >= near * len(apart)


def test_no_proof_is_finer_than_the_accuracy_asks() -> None:
    questions = Questions({"jerk": Curve(0.031, 211.0)}, [1e6])
    close_in(cast(Oracle, questions), known(questions))
    finest = min(tolerance for _, _, tolerance, _ in questions.asked)
    assert finest >= 0.1 * ACCURACY * 0.031


def order_of_trials(seconds: float, excluded: dict[str, float]) -> list[str]:
    """Names of numbers by their trials; ``excluded``: shares of their ways, known before."""
    curves = {"near": Curve(0.05, 211.0), "far": Curve(0.05, 83.0)}
    questions = Questions(curves, [seconds])
    boundaries = known(questions)
    for boundary in boundaries:
        name = boundary.number.name
        boundary.exclude(REQUEST + excluded[name] * curves[name].way)
    close_in(cast(Oracle, questions), boundaries)
    return [name for name, *_ in questions.asked]


def test_a_number_of_which_little_is_excluded_comes_first() -> None:
    names = order_of_trials(1e6, {"near": 0.95, "far": 0.1})
    assert names[0] == "far"


def test_then_the_nearest_to_its_end_is_brought_there() -> None:
    """A trial of the other one would take from its time."""
    names = order_of_trials(1e6, {"near": 0.97, "far": 0.95})
    assert names.index("far") > 1
    assert "near" not in names[names.index("far") :]


def test_a_trial_may_take_longer_than_the_one_before() -> None:
    """In equal shares of the time no proof would end at the accuracy: 0.13 and 0.07 of the way."""
    questions = Questions(pair(0.031, 211.0, -0.4), [120.0])
    boundaries = known(questions)
    close_in(cast(Oracle, questions), boundaries)
    assert min(shares(questions, boundaries)) <= ACCURACY


def test_one_that_waits_comes_after_the_others() -> None:
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    waiting, ready = closing(questions), closing(questions)
    waiting.boundary.exclude(REQUEST + 200.0)
    ready.boundary.exclude(REQUEST + 190.0)
    assert waiting.rank < ready.rank
    waiting._wait(10.0)
    assert ready.rank < waiting.rank


def test_one_of_which_nothing_is_learnt_leaves_the_others_their_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Another trial of it would have as much as both of them need."""
    curves = {"hopeless": Curve(0.05, 211.0), "a": Curve(0.08, 211.0), "b": Curve(0.05, 83.0)}
    questions, relaxed = Questions(curves, [220.0]), Questions.relaxed
    nothing = answer(0.1, 1.0)
    nothing.excess = nothing.bound_excess = None

    def late(self: Questions, number: Relaxable, *given: Any, **more: Any) -> Any:
        if number.name != "hopeless":
            return relaxed(self, number, *given, **more)
        self.asked.append((number.name, *given, False))
        self.seconds[0] -= self.left
        return nothing

    monkeypatch.setattr(Questions, "relaxed", late)
    boundaries = known(questions)
    close_in(cast(Oracle, questions), boundaries)
    assert max(shares(questions, boundaries)[1:]) <= ACCURACY
    assert [name for name, *_ in questions.asked].count("hopeless") == 1


def test_one_trial_changes_the_slope_by_no_more_than_a_factor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The zero that it says would be anywhere: a cam may be far from the smallest."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    for excess in (-1e-4, -0.045):
        found = closing(questions)
        found.boundary.exclude(REQUEST + 200.0)
        before = found.slope
        found.points.append(Point(0.9 * found.good, 0.0, 1e-5))
        cam = answer(excess, 1e-6)
        monkeypatch.setattr(Questions, "relaxed", lambda *_, cam=cam, **__: cam)
        found._try(found.good, 1e-5, None)
        factor = found.slope / before
        assert max(factor, 1.0 / factor) == pytest.approx(longer_proofs.STEEPER)


def test_the_slope_is_that_to_the_nearest_cam_that_differs_for_certain() -> None:
    """Smallest cams are known to a tolerance: two that differ by less say nothing of the slope."""
    found = closing(Questions({"jerk": Curve(0.05, 211.0)}, [1e6]))
    found.points += [Point(200.0, 2e-3, 1e-5), Point(208.0, 2e-4, 5e-4), Point(210.0, 1e-4, 1e-5)]
    found._follow_slope()
    assert found.slope == pytest.approx(1.9e-3 / 10.0)
    found.points.append(Point(210.0, -1e-4, 1e-5))  # once more at the same value
    found._follow_slope()
    assert found.slope == pytest.approx(2.1e-3 / 10.0)


def test_a_gap_that_time_has_left_says_which_value_it_excludes() -> None:
    """No trial is made twice, and the next one lies where the gap excludes it."""
    curve = Curve(0.0037, 211.0)
    questions = Questions({"jerk": curve}, [40.0])
    boundaries = known(questions)
    close_in(cast(Oracle, questions), boundaries)
    assert ACCURACY < max(shares(questions, boundaries)) < 0.3
    assert len(set(questions.asked)) == len(questions.asked)


def test_time_that_one_number_leaves_is_given_to_another() -> None:
    """The one is near at once; the other one's proofs take more than half of the time."""
    curves = {"easy": Curve(0.8, 211.0), "hard": Curve(0.012, 83.0)}
    questions = Questions(curves, [150.0])
    boundaries = known(questions)
    close_in(cast(Oracle, questions), boundaries)
    assert max(shares(questions, boundaries)) <= ACCURACY


def test_a_number_of_which_nothing_is_learnt_is_not_asked_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Proofs that come to nothing are repeated with finer tolerances, then left alone."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e9])
    nothing = answer(0.1, 1.0)
    nothing.excess = nothing.bound_excess = None
    monkeypatch.setattr(
        Questions, "relaxed",
        lambda self, number, value, tolerance, **_: (
            self.asked.append((number.name, value, tolerance, False)), nothing
        )[1],
    )  # fmt: skip
    close_in(cast(Oracle, questions), known(questions))
    tolerances = [tolerance for _, _, tolerance, _ in questions.asked]
    assert len(tolerances) == longer_proofs.IDLE
    assert tolerances == sorted(tolerances, reverse=True)


def test_a_cam_that_is_found_is_named_if_the_question_as_it_stands_has_one() -> None:
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    (boundary,) = known(questions)
    close_in(cast(Oracle, questions), [boundary])
    assert boundary.needed in questions.as_it_stands
    assert boundary.nearest is not None
    assert boundary.confirmed == boundary.nearest[0]  # the last one too, however little it gains
    assert len(questions.as_it_stands) <= 5


def test_a_cam_with_a_value_near_enough_is_put_as_it_stands_however_little_that_is() -> None:
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    found = closing(questions)
    found.boundary.exclude(REQUEST + 210.3)
    found.boundary.needed = found.boundary.confirmed = REQUEST + 212.5
    found.boundary.record(REQUEST + 211.5, cast(Trial, answer(-1e-4, 1e-9)))
    assert found.apart > ACCURACY
    found.advance(cast(Oracle, questions), 10.0)
    assert questions.as_it_stands == [REQUEST + 211.5]
    assert found.apart <= ACCURACY


def test_no_tolerance_is_finer_than_cone_programs_reach() -> None:
    questions = Questions({"jerk": Curve(1e-4, 211.0)}, [1e6])
    close_in(cast(Oracle, questions), known(questions))
    assert min(tolerance for _, _, tolerance, _ in questions.asked) == longer_proofs.FINEST


def closing(questions: Questions) -> Closing:
    (boundary,) = known(questions)
    found = Closing.of(boundary)
    assert found is not None
    return found


def test_a_gap_that_was_left_moves_the_next_value_until_it_promises_nothing() -> None:
    """Then another trial is made as soon as there is more time for it."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    hard = closing(questions)
    hard.points.append(Point(1.0, 0.05, 1e-3))
    near, *_ = hard._next_trial() or [0.0]
    hard.open_gap = 0.02
    farther, *_ = hard._next_trial() or [0.0]
    assert 0.0 < farther < near
    assert hard.slope * (hard.zero - farther) > 0.02
    hard.open_gap = 0.05
    assert hard._next_trial() is None
    for _ in range(2):
        hard.advance(cast(Oracle, questions.share(2)), 10.0)
    assert len(questions.asked) == 1


def test_no_value_beyond_one_that_suffices_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search at that value may find a worse cam than the one that is known."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    found = closing(questions)
    found.boundary.exclude(REQUEST + 200.0)
    worse = answer(2e-5, 1e-4)
    monkeypatch.setattr(Questions, "relaxed", lambda *_, **__: worse)
    found.advance(cast(Oracle, questions), 10.0)
    assert found.points[-1].way == found.good == found.zero


def test_where_no_value_is_known_there_is_nothing_to_bring_near() -> None:
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    (boundary,) = known(questions)
    assert Closing.of(boundary) is not None
    assert Closing.of(replace(boundary, nearest=None)) is None
    unproven = replace(boundary, original=cast(Trial, answer(0.05, 1.0)), excluded=None)
    assert Closing.of(unproven) is None


def test_a_question_as_it_stands_that_takes_long_is_not_put_again_at_once() -> None:
    """The others are tried first; it is put again when there is more time for it."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [100.0], asking=60.0)
    found = closing(questions)
    cam = answer(-1e-6, 1e-9)
    found.boundary.record(REQUEST + 1.001 * 211.0, cast(Trial, cam))
    for _ in range(2):
        found.boundary.exclude(REQUEST + 0.9 * 211.0)
        found.advance(cast(Oracle, questions.share(2)), 10.0)
        assert found.waits_for == 10.0
    assert len(questions.as_it_stands) == 2


def test_what_was_found_last_is_named_too() -> None:
    """A tenth of the time is kept for that, an equal part of it for each number."""
    questions = Questions(pair(0.0123, 83.0, 0.7), [63.0], asking=3.0)
    boundaries = known(questions)
    close_in(cast(Oracle, questions), boundaries)
    for boundary in boundaries:
        assert boundary.nearest is not None
        assert boundary.confirmed == boundary.nearest[0]


def test_where_programs_are_counted_no_trial_is_repeated() -> None:
    """It would come to the same again, however many more are left to it."""
    questions = Questions(pair(0.0037, 211.0, 0.0), [40.0], last_program=1e9)
    close_in(cast(Oracle, questions), known(questions))
    assert len(set(questions.asked)) == len(questions.asked)
    waiting = closing(Questions({"jerk": Curve(0.05, 211.0)}, [1e6], last_program=1e9))
    waiting._wait(10.0)
    assert waiting.waits_for == inf


def test_a_trial_that_ends_late_without_a_gain_is_not_made_again_at_once() -> None:
    """Of a cam, or of a smallest cam: with a finer tolerance it would take longer still."""
    questions = Questions({"jerk": Curve(0.0037, 211.0)}, [1e6])
    found = closing(questions)
    found.boundary.exclude(REQUEST + 200.0)
    found.advance(cast(Oracle, replace(questions, part=0.5, began=questions.seconds[0])), 0.5)
    assert not found.bad > 200.0
    assert found.waits_for == 0.5


def test_a_smallest_radius_is_sought_at_the_value_itself() -> None:
    """Its own cam is the value that suffices, and its bound the one that is impossible."""
    questions = Questions({"base radius": Curve(0.05, 211.0)}, [1e6])
    found = closing(questions)
    path = ("base_radius_mm/max",)
    found.boundary.number = replace(found.boundary.number, paths=path, dimension="base_radius_mm")
    assert found.boundary.number.minimised
    way, tolerance, enough = found._next_trial() or (0.0, 0.0, 0.0)
    assert way == found.good
    assert enough is None
    excess = found.boundary.excesses[REQUEST]
    assert tolerance == pytest.approx(longer_proofs.PROOF_SIDE * excess / (1.0 + excess))


def test_a_question_with_a_smallest_radius_as_its_maximum_has_some_room() -> None:
    """Few cams are as small as that, and the search may end with another one."""
    questions = Questions({"base radius": Curve(0.05, 211.0)}, [1e6])
    found = closing(questions)
    path = ("base_radius_mm/max",)
    found.boundary.number = replace(found.boundary.number, paths=path, dimension="base_radius_mm")
    for least in (212.0, 211.5):
        found.boundary.nearest = REQUEST + least, cast(Trial, answer(0.0, 1e-9))
        found._leave_room()
        assert found.good == pytest.approx((1.0 + longer_proofs.CAM_SIDE) * least)
    smallest = SimpleNamespace(radius=REQUEST + 211.5, attempt=None, is_bounded=False)
    cam = answer(2e-5, 1e-6)
    cam.smallest = smallest
    found.boundary.oracle = cast(Oracle, SimpleNamespace(relaxed=lambda *_, **__: cam))
    found._try(found.good, 1e-5, None)
    assert found.good == pytest.approx((1.0 + longer_proofs.CAM_SIDE) * 211.5)
    found.boundary.needed = REQUEST + 211.6  # that is known to suffice
    found.boundary.nearest = REQUEST + 211.4, cast(Trial, answer(0.0, 1e-9))
    found._leave_room()
    assert found.good == pytest.approx(211.6)
    found.boundary.needed = None
    found._leave_room()
    assert found.good == pytest.approx((1.0 + longer_proofs.CAM_SIDE) * 211.6)


def test_a_search_for_a_smallest_radius_that_ends_late_waits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Room is left for what a search has found, once."""
    questions = Questions({"base radius": Curve(0.05, 211.0)}, [1e6])
    found = closing(questions)
    path = ("base_radius_mm/max",)
    found.boundary.number = replace(found.boundary.number, paths=path, dimension="base_radius_mm")
    nothing = answer(0.1, 1.0)
    nothing.excess = nothing.bound_excess = None

    def late(self: Questions, *_: Any, **__: Any) -> Any:
        self.seconds[0] -= self.left
        return nothing

    monkeypatch.setattr(Questions, "relaxed", late)
    found.boundary.needed = REQUEST + 2.0 * found.good
    good = found.good
    found.advance(cast(Oracle, questions.share(2)), 10.0)
    assert found.good == good
    assert found.waits_for == 10.0


def test_a_bound_short_of_the_request_is_none_to_begin_with() -> None:
    (boundary,) = known(Questions({"jerk": Curve(0.05, 211.0)}, [1e6]))
    boundary.excluded = REQUEST - 1.0
    assert Closing.of(boundary) is None


def test_a_proof_that_succeeds_forgets_the_gap_of_another_value() -> None:
    """One that a proof could not close promised nothing between the excluded value and the zero."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e3])
    closing = Closing.of(known(questions)[0])
    assert closing is not None
    closing.zero, closing.open_gap = 211.0, 0.04
    assert closing._next_trial() is None
    closing._try(140.0, 1e-3, None)
    assert closing.bad == pytest.approx(140.0)
    assert closing._next_trial() is not None


def test_one_that_is_never_confirmed_leaves_the_others_their_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    questions = Questions({"a": Curve(0.05, 211.0), "b": Curve(0.05, 83.0)}, [10.0], asking=2.0)
    ask, boundaries = Questions.ask_as_it_stands, known(questions)

    def never_a(self: Questions, number: Relaxable, value: float, proof: str, **more: Any) -> Any:
        found = ask(self, number, value, proof, **more)
        none = SimpleNamespace(certified=False, excess=None, smallest=None)
        return found if number.name == "b" else none

    monkeypatch.setattr(Questions, "ask_as_it_stands", never_a)
    for boundary in boundaries:
        way = questions.curves[boundary.number.name].way
        boundary.exclude(REQUEST + 0.9999 * way)
        boundary.needed = REQUEST + 1.003 * way
        boundary.record(REQUEST + 1.002 * way, cast(Trial, answer(-1e-6, 1e-9)))
    boundaries[0].needed = None
    close_in(cast(Oracle, questions), boundaries)
    assert boundaries[1].needed == pytest.approx(REQUEST + 1.002 * 83.0)


def test_each_trial_has_an_equal_part_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    questions, parts = Questions(pair(0.0037, 211.0, 0.0), [60.0]), list[float]()
    relaxed = Questions.relaxed

    def noted(self: Questions, *given: Any, **more: Any) -> Any:
        parts.append(self.left / self.seconds[0])
        return relaxed(self, *given, **more)

    monkeypatch.setattr(Questions, "relaxed", noted)
    close_in(cast(Oracle, questions), known(questions))
    assert max(parts[:4]) <= 0.5


def test_a_trial_that_takes_all_its_time_and_shows_nothing_is_made_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [60.0])
    nothing = answer(0.1, 1.0)
    nothing.excess = nothing.bound_excess = None

    def late(self: Questions, number: Relaxable, value: float, *_: Any, **__: Any) -> Any:
        self.asked.append((number.name, value, 0.0, False))
        self.seconds[0] -= self.left
        return nothing

    monkeypatch.setattr(Questions, "relaxed", late)
    found = closing(questions)
    for _ in range(2):
        share = questions.left / 2
        if share > found.waits_for:
            found.advance(cast(Oracle, questions.share(2)), share)
    assert len(questions.asked) == 1


def test_a_proof_ends_with_a_cam_of_little_excess_there() -> None:
    """It would exclude nothing, and go on for all of its time: the zero is farther away."""
    found = closing(Questions({"jerk": Curve(0.05, 211.0)}, [1e6]))
    found.boundary.exclude(REQUEST + 190.0)
    found.points.append(Point(found.good, found.slope, 1e-5))
    found.zero, tolerances = 0.999 * found.good, list[float]()
    way, tolerance, enough = found._next_trial() or (0.0, 0.0, None)
    assert enough == pytest.approx(longer_proofs.HOPELESS * tolerance)

    def relaxed(*given: Any, enough: float, **_: Any) -> Any:
        tolerances.append(enough)
        return answer(1.2 * enough, 3.0 * tolerance, 0.0)  # as the certificate measures it

    found.boundary.oracle = cast(Oracle, SimpleNamespace(relaxed=relaxed))
    found._try(way, tolerance, enough)
    assert tolerances == [enough]
    assert found.points[-1][:2] == pytest.approx((way, 1.2 * enough))
    assert found.open_gap == 0.0


def test_after_a_nearer_value_a_proof_is_tried_half_way_to_the_one_that_failed() -> None:
    """Not that one once more: it would take as long again."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    found = closing(questions)
    found.points.append(Point(1.0, 0.05, 1e-3))
    first, tolerance, _ = found._next_trial() or (0.0, 0.0, 0.0)
    left = answer(0.006, 0.02)
    left.proof, left.excess, left.bound_excess = "", 1e-3, -5e-3
    found.boundary.oracle = cast(Oracle, SimpleNamespace(relaxed=lambda *_, **__: left))
    found._try(first, tolerance, 0.0)
    assert found.unproven == first
    assert found.zero == pytest.approx(first + 1e-3 / found.slope)  # no farther than that
    nearer, *_ = found._next_trial() or (inf,)
    assert nearer < first
    proven = answer(0.02, 0.001)
    found.boundary.oracle = cast(Oracle, SimpleNamespace(relaxed=lambda *_, **__: proven))
    found._try(nearer, tolerance, 0.0)
    assert found.bad == pytest.approx(nearer)
    found.boundary.nearest = REQUEST + found.zero, cast(Trial, answer(0.0, 1e-9))
    half_way, tolerance_there, enough = found._next_trial() or (inf, 0.0, 0.0)
    assert half_way == pytest.approx(0.5 * (nearer + first))
    assert enough == pytest.approx(longer_proofs.HOPELESS * tolerance_there)
    assert tolerance_there == pytest.approx(
        longer_proofs.WITHIN * found.slope * (found.zero - half_way)
    )
    found._try(first, tolerance, 0.0)
    assert found.unproven == inf  # proven after all, on the way to a cam
    found.boundary.oracle = cast(Oracle, questions)
    found.unproven, found.boundary.excluded = first, REQUEST + nearer
    found._wait(10.0)  # with more time one as near is tried again
    assert (found._next_trial() or [0.0])[0] >= first


@pytest.mark.parametrize(("beyond", "end"), [(1.03, 180.0), (1.002, 120.0)])
def test_where_the_excess_is_flat_beside_its_zero_the_bracket_is_divided(
    beyond: float, end: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another limit binds from there on: the slope beyond says nothing, and is not crept along."""
    questions, relaxed = Questions({"jerk": Curve(0.05, 211.0)}, [1e6]), Questions.relaxed

    def flat(self: Questions, number: Relaxable, value: float, *given: Any, **more: Any) -> Any:
        steep = value if value - REQUEST < end else REQUEST + 211.0 * beyond
        return relaxed(self, number, steep, *given, **more)

    monkeypatch.setattr(Questions, "relaxed", flat)
    (boundary,) = known(questions)
    close_in(cast(Oracle, questions), [boundary])
    assert boundary.nearest is not None
    assert boundary.excluded is not None
    assert boundary.excluded < REQUEST + end <= boundary.nearest[0]
    assert boundary.nearest[0] - boundary.excluded <= ACCURACY * end
    assert len(questions.asked) < 25
    assert boundary.needed is not None
    assert boundary.needed > REQUEST + 211.0  # what was known: as they stand, others have none


def test_a_question_as_it_stands_has_the_time_of_some_trials(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is asked with two or three tolerances; less time would be lost."""
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [100.0], asking=9.0)
    found = closing(questions)
    found.boundary.exclude(REQUEST + 0.999 * 211.0)
    found.boundary.record(REQUEST + 1.002 * 211.0, cast(Trial, answer(-1e-4, 1e-9)))
    other = closing(questions)
    monkeypatch.setattr(Closing, "of", lambda each: each)
    monkeypatch.setattr(Closing, "is_done", False)
    parts = list[float]()

    def noted(self: Closing, oracle: Any, share: float) -> None:
        parts.append(oracle.left)
        assert self is found
        assert share == pytest.approx(oracle.left)
        raise TimeoutError

    monkeypatch.setattr(Closing, "advance", noted)
    for took in (3.0, 7.0, 0.0):
        found.took = took
        with pytest.raises(TimeoutError):
            close_in(cast(Oracle, questions), cast(Any, [found, *[other] * 9]))
    assert parts == pytest.approx([9.0, 21.0, 9.0])  # an equal share of 90 s is 9


@pytest.mark.parametrize(
    ("excess", "bound", "unknown"),
    [(-2e-3, -1.0, 2e-3), (-2e-3, -2.7e-3, 7e-4), (-1e-5, -1.0, 5e-4)],
)
def test_how_far_a_cam_is_from_the_smallest_is_known_by_its_bound(
    excess: float, bound: float, unknown: float
) -> None:
    """A search that ends with a cam far below the maximum says little of the slope."""
    found = closing(Questions({"jerk": Curve(0.05, 211.0)}, [1e6]))
    cam = answer(0.0, 1e-9)
    cam.excess, cam.bound_excess, cam.certified, cam.proof = excess, bound, True, ""
    found.boundary.oracle = cast(Oracle, SimpleNamespace(relaxed=lambda *_, **__: cam))
    found._try(200.0, 5e-4, 1e-4)
    assert found.points[-1].excess == excess
    assert found.points[-1].tolerance == pytest.approx(unknown, rel=1e-2)


def test_a_cam_of_a_longer_proof_is_known_to_need_one() -> None:
    questions = Questions({"jerk": Curve(0.05, 211.0)}, [1e6])
    found = closing(questions)
    found._try(0.5 * 211.0, 1e-3, 1e-4)
    assert not found.boundary.needs_proof
    found._try(1.01 * 211.0, 1e-4, None)
    assert found.boundary.needs_proof
