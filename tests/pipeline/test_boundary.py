"""How near to each other a value that suffices and one that is proven impossible come."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, sqrt
from types import SimpleNamespace
from typing import Any, cast

import pytest

from synthesis import synthesise
from synthesis.catalogue.fields import Range
from synthesis.design.design import Conflict
from synthesis.numerics import clock
from synthesis.pipeline import boundary, conflict, longer_proofs, outwards
from synthesis.pipeline.boundary import Boundary
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import solve_with_maximum
from synthesis.pipeline.oracle import Oracle, Trial, gap_left_by, missing_excess
from synthesis.pipeline.program_numbers import program_numbers
from synthesis.pipeline.relaxable import Relaxable, relaxable_numbers
from synthesis.spec.design_spec import DesignSpec
from tests.hard.families import random_scene
from tests.optimise.scenes import (
    PLAIN,
    acceleration,
    angles,
    dwell,
    fall,
    jerk,
    rise,
    scene,
    velocity,
)

NEAR = 1e-3  # of the way from the request
# One free law is enough where two would say the same twice: the long way back keeps every cap.
ONE_FREE = (rise(71.7), dwell(23.9), fall(170.0, law="cycloidal"), dwell(94.4))


@pytest.fixture(autouse=True)
def changes_of_the_program_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """They have tests of their own, and take as many questions again."""
    monkeypatch.setattr(conflict, "program_numbers", lambda *_: ())


def why(spec: DesignSpec) -> Conflict:
    found = synthesise(spec).conflict
    assert found is not None
    return found


def test_the_least_cap_on_jerk_is_that_of_the_closed_form() -> None:
    """32 h/β³, made the objective, which bounds it as well."""
    (found,) = why(scene(PLAIN, jerk(31.0, 71.7), base={"min": 4.3})).relaxations
    least = 32.0 / 31.0 * found.requested
    assert found.needed is not None
    assert found.at_least is not None
    assert found.at_least <= least <= found.needed
    assert found.needed - found.at_least < 2e-4 * least


def test_both_ends_come_near_where_the_smallest_cam_is_too_large() -> None:
    spec = scene(PLAIN, angles(20.0, 30.0), jerk(47.0, 71.7), base={"max": 30.0})
    relaxations = why(spec).relaxations
    assert len(relaxations) == 3
    for each in relaxations:
        assert each.needed is not None
        assert each.at_least is not None
        assert 0.0 <= (each.needed - each.at_least) / (each.needed - each.requested) < NEAR


def dimensions(spec: DesignSpec) -> list[Relaxable]:
    """Its dimensions alone: each limit would take as many questions again."""
    return [number for number in relaxable_numbers(spec) if number.dimension]


def test_the_spec_says_how_near(monkeypatch: pytest.MonkeyPatch) -> None:
    """``proof`` buys accuracy: a finer tolerance brings both ends nearer."""
    monkeypatch.setattr(conflict, "relaxable_numbers", dimensions)
    spec = scene(PLAIN, angles(31.0, 43.0), jerk(47.0, 71.7), base={"max": 1e3})
    radius = synthesise(spec).dimensions["base_radius_mm"]
    apart = list[float]()
    for proof in ("quick", "thorough"):
        changes = {"base_radius_mm": Range(max=0.998 * radius), "proof": proof}
        found = why(spec.model_copy(update=changes)).relaxations[-1]
        assert found.field == "base_radius_mm/max"
        assert found.needed is not None
        assert found.at_least is not None
        apart.append((found.needed - found.at_least) / (found.needed - found.requested))
    assert apart[1] < 0.8 * apart[0]
    assert apart[1] < 5e-3


def test_a_request_that_is_next_to_what_suffices_has_ends_as_near_in_proportion() -> None:
    """A thousandth of the way, also where the way is a thousandth of the value."""
    law = {"kind": "modified_sine"}
    program = [
        {"kind": "rise", "angle_deg": 102.0, "lift_mm": 23.5, "law": law},
        {"kind": "dwell", "angle_deg": 48.0},
        {"kind": "return", "angle_deg": 104.0, "lift_mm": 23.5, "law": law},
        {"kind": "dwell", "angle_deg": 106.0},
    ]
    limit = {"kind": "pressure_angle", "rise_deg": 37.1, "return_deg": 39.4}
    spec = DesignSpec.model_validate({
        "program": program, "follower": {"kind": "translating_roller", "roller_radius_mm": 7.0},
        "limits": [limit],
    })  # fmt: skip
    radius = synthesise(spec).dimensions["base_radius_mm"]
    short = spec.model_copy(update={"base_radius_mm": Range(max=0.9985 * radius)})
    relaxations = why(short).relaxations
    assert len(relaxations) == 3
    for each in relaxations:
        assert each.needed is not None
        assert each.at_least is not None
        assert 0.0 <= (each.needed - each.at_least) / (each.needed - each.requested) < NEAR


@pytest.mark.parametrize(
    ("family", "changes", "most", "name"),
    [
        ("slide, centred", {"jerk": {"max_mm_per_s3": 9764842.44}}, 26.5571, "pressure angle rise"),
        ("face, width", {}, 7.2845, "profile radius"),
    ],
)
def test_both_ends_come_near_where_knots_of_a_neighbour_leave_a_gap(
    family: str, changes: Mapping[str, Mapping[str, float]], most: float, name: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Wider than the tolerance, and yet so narrow that halved intervals gain nothing."""
    body = random_scene(family, 8)
    limits = [{**limit, **changes.get(limit["kind"], {})} for limit in body["limits"]]
    spec = DesignSpec.model_validate(
        {**body, "base_radius_mm": {"max": most}, "limits": limits, "proof": "thorough"}
    )
    numbers = [each for each in relaxable_numbers(spec) if each.name == name]
    monkeypatch.setattr(conflict, "relaxable_numbers", lambda _: numbers)
    (each,) = why(spec).relaxations
    assert each.needed is not None
    assert each.at_least is not None
    assert 0.0 <= (each.needed - each.at_least) / (each.needed - each.requested) < NEAR


def test_a_gap_that_the_quick_proof_leaves_is_closed_by_the_spec_s_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A small cam under a large roller is at its least radius of curvature: that is not convex.

    That ``auto`` has no longer proofs unless the spec gives time is asked below.
    """
    body = random_scene("slide, centred", 2)
    limits = [limit if limit["kind"] != "jerk" else {**limit, "max_mm_per_s3": 308600.0}
              for limit in body["limits"]]  # fmt: skip
    short = {**body, "base_radius_mm": {"max": 6.7243}, "limits": limits}
    ways = {}
    for proof in ("quick", "thorough"):
        spec = DesignSpec.model_validate({**short, "proof": proof})
        numbers = [each for each in relaxable_numbers(spec) if each.name == "jerk"]
        monkeypatch.setattr(conflict, "relaxable_numbers", lambda _, numbers=numbers: numbers)
        (each,) = why(spec).relaxations
        assert each.needed is not None
        assert each.at_least is not None
        ways[proof] = (each.needed - each.at_least) / (each.needed - each.requested)
    assert ways["quick"] > 0.1
    assert 0.0 <= ways["thorough"] <= longer_proofs.ACCURACY


@pytest.mark.parametrize(("share", "is_open"), [(0.99, False), (1.01, True)])
def test_a_gap_is_open_where_it_is_wider_than_the_tolerance_of_the_cam(
    share: float, is_open: bool
) -> None:
    """Excesses are relative to the maximum, a tolerance to the cam, which is larger."""
    excess, tolerance = 0.37, 9e-3
    below = excess - share * tolerance * (1.0 + excess)
    trial: Any = SimpleNamespace(excess=excess, bound_excess=below)
    boundary: Any = SimpleNamespace(oracle=SimpleNamespace(open_gap=0.0))
    Boundary._note_gap(boundary, trial, tolerance)
    assert (boundary.oracle.open_gap > 0.0) is is_open


LEAST = 1300.0  # of a number that is asked to be 1000 at most


def bounded(found: dict[float, float | None], monkeypatch: pytest.MonkeyPatch) -> Boundary:
    """What is known of that number, with excesses of questions as they stand by its value."""

    def ask(_number: Any, value: float, _proof: str, **_: Any) -> Any:
        excess = 2e-3 * (LEAST - value) / 1000.0
        found[value] = excess
        return SimpleNamespace(
            certified=excess <= 0.0, excess=excess, bound_excess=None, smallest=None
        )

    oracle = SimpleNamespace(
        spec=SimpleNamespace(tolerance=5e-3, proof="auto"), open_gap=0.0, has_longer_proofs=False,
        is_late=lambda: False,
        is_valid=lambda *_: True, ask_as_it_stands=ask, value_on=lambda *_: (None, ""),
    )  # fmt: skip
    number = Relaxable("jerk", ("limits/0/max_mm_per_s3",), (1000.0,), "mm/s³", "≤")
    request = SimpleNamespace(excess=6e-4, bound_excess=None, proof="", smallest=None)
    known = Boundary(cast(Oracle, oracle), number, cast(Trial, request))
    known.excesses[1250.0] = 1e-4  # another search came nearer than the question as it stands
    known.nearest = 1280.0, cast(Trial, request)
    return known


def test_what_a_question_as_it_stands_misses_says_which_value_to_put_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[float, float | None] = {}
    known = bounded(asked, monkeypatch)
    known.confirm()
    assert len(asked) == 2
    assert known.needed is not None
    assert LEAST <= known.needed <= LEAST + 10.0
    known.confirm()  # nothing nearer was found since
    assert len(asked) == 2


@pytest.mark.parametrize(
    ("own", "proof", "found_by", "asked"),
    [
        ("quick", "quick", "none", ["cam", "quick"]),
        ("quick", "quick", "quick", ["cam", "quick"]),
        ("auto", "quick", "cam", ["cam"]),
        ("auto", "quick", "none", ["cam"]),  # its own proof comes later
        ("auto", "auto", "cam", ["cam"]),
        ("auto", "auto", "auto", ["cam", "auto"]),
        ("thorough", "thorough", "thorough", ["cam", "thorough"]),
    ],
)
@pytest.mark.parametrize("late", [False, True])
def test_the_spec_s_own_proof_follows_where_a_cam_alone_is_not_found(
    own: str,
    proof: str,
    found_by: str,
    asked: list[str],
    *,
    late: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known, proofs = bounded({}, monkeypatch), list[str]()

    def ask(_number: Any, _value: float, proof: str, *, cam_only: bool = False) -> Any:
        proofs.append("cam" if cam_only else proof)
        return SimpleNamespace(certified=proofs[-1] == found_by, excess=None, smallest=None)

    assert known.nearest is not None
    nearest, answers = known.nearest[0], cast(Any, known.oracle)
    answers.ask_as_it_stands, answers.is_valid = ask, lambda _, value: value == nearest
    answers.is_late, answers.spec.proof = lambda: late and bool(proofs), own
    known.confirm(proof)
    assert proofs == (asked[:1] if late else asked)
    assert known.needed == (nearest if found_by in proofs else None)


@pytest.mark.parametrize("proof", ["quick", "auto"])
def test_a_cam_of_a_longer_proof_is_put_with_the_spec_s_own_at_once(
    proof: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A quick search has found none as near."""
    known, proofs = bounded({}, monkeypatch), list[str]()

    def ask(_number: Any, _value: float, proof: str, *, cam_only: bool = False) -> Any:
        proofs.append("cam" if cam_only else proof)
        return SimpleNamespace(certified=True, excess=None, smallest=None)

    cast(Any, known.oracle).ask_as_it_stands = ask
    cast(Any, known.oracle).spec.proof = "auto"
    known.needs_proof = True
    known.confirm(proof)
    assert proofs == ["cam" if proof == "quick" else "auto"]


@pytest.mark.parametrize(
    ("kept", "proofs", "farther"),
    [
        (2e-5, ["cam"], 0.0),
        (4e-6, ["auto"], 0.0),  # another's search ends within a millionth of the best
        (3e-7, ["auto"], 1.3 * 7e-7 / 2e-6),  # as much farther as is missing, by the excess's fall
        (0.0, ["auto"], 1.3 * 1e-6 / 2e-6),
    ],
)
def test_a_cam_next_to_the_best_is_put_with_a_bound_and_a_little_farther(
    kept: float, proofs: list[str], farther: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``kept``: of a maximum, by how much the nearest cam is smaller; the request is at 6e-4."""
    known, asked = bounded({}, monkeypatch), list[tuple[float, str]]()

    def ask(_number: Any, value: float, proof: str, *, cam_only: bool = False) -> Any:
        asked.append((value, "cam" if cam_only else proof))
        return SimpleNamespace(certified=True)

    nearest = 1000.0 + (6e-4 + kept) / 2e-6
    trial: Any = SimpleNamespace(excess=-kept, bound_excess=None, smallest=None)
    known.nearest, cast(Any, known.oracle).ask_as_it_stands = (nearest, trial), ask
    known.confirm("auto")
    assert [proof for _, proof in asked] == proofs
    assert asked[0][0] == pytest.approx(nearest + farther, rel=1e-9)
    assert known.needed == asked[0][0]


@pytest.mark.parametrize(
    ("excess", "bound", "missing"),
    [
        (None, None, 0.0),
        (-2e-6, None, 0.0),
        (-2e-7, None, 8e-7),
        (-2e-7, -0.1, 8e-7),
        (-2e-7, -2e-7, 0.0),  # no gap: another's search ends there as well
        (-2e-7, -6e-7, 2e-7),
        (3e-4, None, 3.01e-4),
    ],
)
def test_what_another_s_search_misses_is_the_excess_and_a_gap_of_a_millionth(
    excess: float | None, bound: float | None, missing: float
) -> None:
    trial: Any = SimpleNamespace(excess=excess, bound_excess=bound)
    assert missing_excess(trial) == pytest.approx(missing, rel=1e-3, abs=1e-15)


@pytest.mark.parametrize(("excess", "is_gap"), [(0.3, True), (-0.05, True), (-0.98, False)])
def test_a_cam_far_below_its_maximum_says_nothing_of_a_gap_at_it(
    excess: float, *, is_gap: bool
) -> None:
    """As next to an infimum of 0, which no bound comes near to."""
    trial: Any = SimpleNamespace(excess=excess, bound_excess=-1.0)
    assert (gap_left_by(trial, 1e-3) > 0.0) is is_gap


@pytest.mark.parametrize(("direction", "taken"), [(1.0, True), (-1.0, False)])
def test_the_smallest_cam_is_the_nearest_value_of_a_radius_that_grows_alone(
    direction: float, *, taken: bool
) -> None:
    """A given radius that is too large comes down: its smallest cam is the farthest value."""
    number = Relaxable("base radius", ("base_radius_mm",), (90.0,), "mm", "=")
    request: Any = SimpleNamespace(excess=None, bound_excess=None, smallest=None, proof="proven")
    oracle = SimpleNamespace(spec=SimpleNamespace(tolerance=5e-3), open_gap=0.0)
    known = Boundary(cast(Oracle, oracle), number, cast(Trial, request))
    known.direction = direction
    least = 90.0 + 13.7 * direction
    smallest = SimpleNamespace(radius=least, lower=least - 1e-3, is_bounded=True, attempt=None)
    found: Any = SimpleNamespace(
        certified=True, excess=-0.1, bound_excess=None, smallest=smallest, proof=""
    )
    known.record(90.0 + 21.9 * direction, found)
    assert known.excluded == (least - 1e-3 if taken else 90.0)
    assert known.nearest is not None
    assert known.nearest[0] == (least if taken else 90.0 - 21.9)


def test_a_farthest_value_is_put_though_a_farther_one_may_not_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known = bounded({}, monkeypatch)
    farthest = 1280.0
    trial: Any = SimpleNamespace(excess=-3e-7, bound_excess=None, smallest=None)
    answers = cast(Any, known.oracle)
    answers.is_valid = lambda _, value: value <= farthest
    answers.ask_as_it_stands = lambda *_, **__: SimpleNamespace(certified=True)
    known.nearest = farthest, trial
    known.confirm()
    assert known.needed == farthest


def test_a_cam_next_to_the_best_is_put_no_more_than_a_hundredth_farther(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A request of which hardly any excess is known has no secant to speak of."""
    known, asked = bounded({}, monkeypatch), list[float]()

    def ask(_number: Any, value: float, *_: Any, **__: Any) -> Any:
        asked.append(value)
        return SimpleNamespace(certified=True)

    known.requested_excess = 1e-6
    trial: Any = SimpleNamespace(excess=0.0, bound_excess=None, smallest=None)
    known.nearest, cast(Any, known.oracle).ask_as_it_stands = (1010.0, trial), ask
    known.confirm()
    assert asked == [pytest.approx(1010.1)]


@pytest.mark.parametrize(
    ("request_is", "value", "way"),
    [(5.0, 4.0, 1.0), (500.0, 4.0, 4.0), (5.0, 0.0, 5e-6), (5.0, -0.01, 0.01), (0.0, 3.0, 3.0)],
)
def test_a_way_is_that_of_the_value_where_the_request_is_far_out_but_never_none(
    request_is: float, value: float, way: float
) -> None:
    number = Relaxable("position", ("limits/0/min_mm",), (request_is,), "mm", "≥")
    request: Any = SimpleNamespace(excess=None, bound_excess=None, smallest=None, proof="")
    oracle = SimpleNamespace(spec=SimpleNamespace(tolerance=5e-3), open_gap=0.0)
    known = Boundary(cast(Oracle, oracle), number, cast(Trial, request))
    assert known._way(value) == pytest.approx(way)


def test_the_excesses_of_laws_and_of_sizes_have_zeros_of_their_own() -> None:
    """The farther zero counts: that of sizes, as soon as a law fits and the size is too large."""

    def trial(excess: float, smallest: object) -> Any:
        fits = excess <= 0.0
        return SimpleNamespace(
            certified=fits, excess=excess, bound_excess=None, smallest=smallest, proof=""
        )

    law, size = None, SimpleNamespace()
    number = Relaxable("jerk", ("limits/0/max_mm_per_s3",), (1000.0,), "mm/s³", "≤")
    oracle = SimpleNamespace(spec=SimpleNamespace(tolerance=5e-3), open_gap=0.0)
    known = Boundary(cast(Oracle, oracle), number, trial(0.31, law))
    known.record(1700.0, trial(-0.06, size))  # far below the maximum: no zero of laws is near
    assert known.excesses == {1000.0: 0.31}
    known.record(1200.0, trial(0.11, law))
    assert known.excesses == {1000.0: 0.31, 1200.0: 0.11}
    known.record(1350.0, trial(0.07, size))  # a law fits, but not the size
    assert known.excesses == {1350.0: 0.07}
    known.record(1250.0, trial(0.06, law))  # nearer to the request laws fail again
    known.record(1610.0, trial(-0.05, size))
    assert known.excesses == {1350.0: 0.07, 1610.0: -0.05}
    known.record(1400.0, trial(0.02, law))  # and farther away too, though not where a cam is
    assert known.excesses == {1400.0: 0.02}
    known.record(1420.0, trial(0.05, size))
    assert known.excesses == {1420.0: 0.05}
    known.record(1510.0, trial(-0.01, size))
    assert known.excesses == {1420.0: 0.05, 1510.0: -0.01}
    assert known.requested_excess == 0.31
    assert known._missing_way(1510.0, trial(1e-3, size)) == 0.0  # of another function
    assert known._missing_way(1200.0, trial(0.11, law)) == pytest.approx(1.3 * 0.110001 * 1e3)


@pytest.mark.parametrize("slope", [6e-4, None])
def test_where_no_cam_tells_an_excess_no_value_is_tried_twice(slope: float | None) -> None:
    """Limits on the motion alone: a question without a cam has an excess, one with a cam none.

    None: no question has one.
    """
    tried, least, request = list[float](), 1015.7, 1000.0

    def relaxed_to(_number: Any, value: float, *_: Any, **_more: Any) -> Any:
        tried.append(float(value))
        return trial_at(value)

    def trial_at(value: float) -> Any:
        fits = value >= least
        missing = None if fits or slope is None else slope * (least - value)
        return SimpleNamespace(
            certified=fits, excess=missing, bound_excess=missing, smallest=None,
            proof="" if fits else "proven", on_time=True,
            attempt=SimpleNamespace(mesh=lambda _: ()),
        )  # fmt: skip

    oracle = SimpleNamespace(
        spec=SimpleNamespace(tolerance=5e-3, proof="auto"), open_gap=0.0, has_longer_proofs=False,
        is_late=lambda: False,
        relaxed=relaxed_to, is_valid=lambda *_: True, value_on=lambda *_: (None, ""),
        ask_as_it_stands=lambda *_, **__: SimpleNamespace(certified=True),
        bound_excess=lambda *_: -inf,
    )  # fmt: skip
    number = Relaxable("acceleration", ("limits/0/max_mm_per_s2",), (request,), "mm/s²", "≤")
    known = Boundary(cast(Oracle, oracle), number, trial_at(request))
    known.nearest, known.finest = (1016.0, trial_at(1016.0)), 1e-6
    known.accuracy = conflict.ACCURACIES[-1]
    known._close_in()
    assert len(set(tried)) == len(tried)
    assert known.excluded is not None
    assert known.excluded < least <= known.nearest[0]
    near = NEAR if slope else 5.0 * NEAR  # halved alone
    assert known.nearest[0] - known.excluded <= near * (known.nearest[0] - request)


def tried_by(oracle_is: dict[str, Any], excess: Any, gap: float) -> tuple[Boundary, list[float]]:
    """A boundary of a request of 1000 that is brought nearer, and a list of the values tried."""
    tried = list[float]()

    def trial_at(_number: Any, value: float, *_: Any, **_more: Any) -> Any:
        tried.append(float(value))
        e = excess(value)
        return SimpleNamespace(
            certified=e <= 0.0, excess=e, bound_excess=e - gap, smallest=None,
            proof="proven" if e > gap else "", on_time=True,
            attempt=SimpleNamespace(mesh=lambda _: ()),
        )  # fmt: skip

    oracle = SimpleNamespace(
        spec=SimpleNamespace(tolerance=5e-3, proof="auto"), open_gap=0.0, is_late=lambda: False,
        relaxed=trial_at, bound_excess=lambda _, __, value: excess(value) - gap, **oracle_is,
    )  # fmt: skip
    number = Relaxable("jerk", ("limits/0/max_mm_per_s3",), (1000.0,), "mm/s³", "≤")
    known = Boundary(cast(Oracle, oracle), number, trial_at(number, 1000.0))
    for value in (1600.0, 1734.0):
        known.record(value, trial_at(number, value))
    tried.clear()
    return known, tried


@pytest.mark.parametrize(
    ("certified", "radius", "excess"), [(True, 1.5, -0.25), (False, 5.0, 1.5), (True, 5.0, None)]
)
def test_a_cam_that_is_small_enough_has_no_excess_of_a_larger_one(
    certified: bool, radius: float, excess: float | None
) -> None:
    """The search without the maximum may end with a cam that is far larger than one with it."""
    attempt: Any = SimpleNamespace(
        certified=certified, searches=[SimpleNamespace(least_excess=None)]
    )
    smallest: Any = SimpleNamespace(radius=radius, most=2.0)
    assert Trial(attempt, smallest, on_time=True).excess == excess


def test_what_is_left_is_counted_in_programs_where_those_are_limited() -> None:
    """So that answers do not depend on the machine, whatever deadline a service sets as well."""
    spec = scene(PLAIN, jerk(31.0, 71.7), base={"min": 4.3})
    now, solved = clock.now(), clock.programs_solved()
    oracle = Oracle(spec, spec, now + 1e6, solved + 300)
    assert oracle.left == 300.0
    assert oracle.share(3.0).left == 100.0
    assert Oracle(spec, spec, now + 1e6).left == pytest.approx(1e6, rel=1e-3)


def test_a_kink_of_the_excess_takes_few_trials() -> None:
    """Where the number no longer binds all values have the same cam, and secants stand still."""
    known, tried = tried_by({}, lambda v: max(0.21 * (1.0 - (v - 1000.0) / 98.3), -0.00237), 1e-4)
    known._narrow()
    assert known.nearest is not None
    assert 1098.3 <= known.nearest[0] <= 1098.3 + 1.1 * boundary.ROUGH * 98.3
    assert len(tried) <= 8


@pytest.mark.parametrize(
    ("longer", "gap", "least", "most"),
    [(True, 3e-2, 1, 1), (True, 1e-2, 1, 1), (True, 1e-3, 2, 5), (False, 3e-2, 2, 5)],
)
def test_a_wide_gap_is_left_to_longer_proofs_where_they_follow(
    longer: bool, gap: float, least: int, most: int
) -> None:
    known, tried = tried_by(
        {"has_longer_proofs": longer}, lambda v: 0.2 * (1.0 - (v - 1000.0) / 98.3), gap
    )
    known._close_in()
    assert least <= len(tried) <= most
    assert known.excluded is not None
    assert known.excluded > 1050.0  # by the multipliers of the first trial, if by no other


@pytest.mark.parametrize(
    ("longer", "multipliers", "open_gap", "is_left"),
    [
        (True, False, 3e-2, True),
        (True, False, 1.2e-3, False),  # quick proofs come near enough
        (True, True, 3e-2, False),  # one trial's multipliers may exclude most of the way
        (False, False, 3e-2, False),
    ],
)
def test_proofs_of_single_values_are_left_to_longer_ones(
    *, longer: bool, multipliers: bool, open_gap: float, is_left: bool
) -> None:
    known, tried = tried_by(
        {"has_longer_proofs": longer}, lambda v: 0.2 * (1.0 - (v - 1000.0) / 98.3), 1e-3
    )
    known.oracle.open_gap = open_gap
    answers = cast(Any, known.oracle)
    if not multipliers:
        answers.bound_excess = lambda *_: -inf
    answers.ask_as_it_stands = lambda *_, **__: SimpleNamespace(certified=True)
    answers.is_valid, answers.value_on = lambda *_: True, lambda *_: (None, "")
    known.seek_bound(conflict.ACCURACIES[-1])
    assert (not tried) == is_left


@pytest.mark.parametrize("excluded", [None, 990.0])
def test_none_are_left_where_longer_ones_do_not_begin(excluded: float | None) -> None:
    known, _ = tried_by(
        {"has_longer_proofs": True}, lambda v: 0.2 * (1.0 - (v - 1000.0) / 98.3), 1e-3
    )
    known.oracle.open_gap = 3e-2
    cast(Any, known.oracle).bound_excess = lambda *_: -inf
    assert known._is_left_to_longer_proofs()
    known.excluded = excluded
    assert not known._is_left_to_longer_proofs()
    assert longer_proofs.Closing.of(known) is None


@pytest.mark.parametrize(
    ("excluded", "needed", "at_least"),
    [(990.0, 1050.0, None), (990.0, None, None), (1000.0, 1050.0, 1000.0), (1020.0, None, 1020.0),
     (1020.0, 1050.0, 1020.0), (1060.0, 1050.0, None)],
)  # fmt: skip
def test_what_is_proven_impossible_lies_between_the_request_and_what_suffices(
    excluded: float, needed: float | None, at_least: float | None
) -> None:
    """A bound of the smallest cam below its maximum excludes none of the values above that."""
    known, _ = tried_by({}, lambda v: 0.2 * (1.0 - (v - 1000.0) / 98.3), 1e-3)
    known.excluded, known.needed = excluded, needed
    assert known.at_least == at_least


def test_a_proof_counts_where_it_came_late() -> None:
    """The member is idle: the others have no cam, which is proven, whatever time it took."""
    names = ("jerk", "acceleration", "velocity")
    numbers = [Relaxable(name, (f"limits/{name}",), (1.0,), "", "≤") for name in names]
    jerk_alone = numbers[:1]

    def trial(*, proof: str, on_time: bool) -> Any:
        return SimpleNamespace(certified=False, proof=proof, on_time=on_time, strained=())

    oracle: Any = SimpleNamespace(
        is_late=lambda: False, proven_without=lambda _: trial(proof="proven", on_time=False)
    )
    members = conflict._irreducible(oracle, numbers, jerk_alone, trial(proof="", on_time=True))
    assert members.numbers == jerk_alone
    assert members.trial.proof
    oracle.proven_without = lambda _: trial(proof="", on_time=False)
    members = conflict._irreducible(oracle, numbers, jerk_alone, trial(proof="", on_time=True))
    assert members.numbers == numbers
    assert members.unconfirmed == numbers[1:]
    assert not members.on_time


def test_the_multipliers_of_a_trial_prove_what_lies_up_to_the_zero() -> None:
    """Two trials bring both ends within the accuracy: one without a cam and one with a cam."""
    spec = scene(PLAIN, angles(27.1, 31.3), jerk(53.0, 71.7), base={"max": 26.9})
    spec = spec.model_copy(update={"proof": "auto"})
    oracle, question = Oracle(spec, spec, inf), solve_with_maximum(spec, Goal(inf), [])
    original = Trial(*question, True)
    (number,) = (each for each in relaxable_numbers(spec) if each.name == "jerk")
    known = Boundary(oracle, number, original)
    outwards.seek_value(known)
    known.narrow()
    before = len(known.trials)
    known.seek_bound(conflict.ACCURACIES[-1])
    assert 1 <= len(known.trials) - before <= 3
    assert known.needed is not None
    assert known.excluded is not None
    assert known.excluded < known.needed
    assert known.needed - known.excluded <= NEAR * (known.needed - number.tightest)
    # It is no trial's own value: multipliers of another one exclude it. And it is the least there.
    assert known.excluded not in known.trials
    shown = oracle.relaxed(number, known.excluded, 1e-6, original, exactly=True, proof="quick")
    assert not shown.certified


def test_the_place_of_a_counter_roller_is_no_part_of_a_bound() -> None:
    body = random_scene("slide, conjugate", 5)
    spec = DesignSpec.model_validate({**body, "base_radius_mm": {"max": 30.0}})
    oracle, trial = Oracle(spec, spec, inf), Trial(*solve_with_maximum(spec, Goal(inf), []), True)
    (number, *_) = (each for each in relaxable_numbers(spec) if each.name == "jerk")
    assert trial.smallest is not None
    found = oracle.bound_excess(trial, number, number.tightest)
    assert trial.bound_excess is not None
    assert found <= trial.bound_excess + 1e-6


def longer_proofs_of(names: list[str], monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What longer proofs are asked for where trials of these numbers leave a gap open."""
    closed, seek_value = list[Any](), conflict.seek_value

    def with_a_gap(known: Boundary) -> None:
        seek_value(known)
        if known.number.name in names:
            known.oracle.open_gap = 1.0

    monkeypatch.setattr(conflict, "seek_value", with_a_gap)
    monkeypatch.setattr(conflict, "close_in", lambda *found: closed.append(found))
    return closed


def test_a_gap_of_another_program_is_none_of_the_one_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No longer proofs are made of members whose own gaps are closed."""
    names = ["speed"]
    closed = longer_proofs_of(names, monkeypatch)
    monkeypatch.setattr(
        conflict,
        "program_numbers",
        lambda spec, chosen: [n for n in program_numbers(spec, chosen) if n.name == "speed"],
    )
    spec = scene(ONE_FREE, jerk(31.0, 71.7), base={"min": 4.3})
    spec = spec.model_copy(update={"proof": "thorough"})
    why(spec)
    assert not closed
    # The gap is open as soon as a value is found: neither end has to come nearer.
    monkeypatch.setattr(Boundary, "narrow", lambda _: None)
    monkeypatch.setattr(Boundary, "seek_bound", lambda *_: None)
    names.append("jerk")
    why(spec)
    ((_, boundaries),) = closed
    assert [each.number.name for each in boundaries] == ["jerk"]
    why(spec.model_copy(update={"proof": "auto"}))  # the spec gives no time for them
    why(spec.model_copy(update={"proof": "quick", "time_budget_s": 3600.0}))
    assert len(closed) == 1
    why(spec.model_copy(update={"proof": "auto", "time_budget_s": 3600.0}))
    assert len(closed) == 2


def test_longer_proofs_are_of_all_numbers_that_are_free(monkeypatch: pytest.MonkeyPatch) -> None:
    """With numbers that were chosen they would hold for these alone."""
    closed = longer_proofs_of(["jerk", "base radius"], monkeypatch)
    free = {**rise(71.7), "angle_deg": {"min": 60.0, "max": 80.0}}
    rest = {**dwell(0.0), "angle_deg": {"min": 100.0, "max": 200.0}}
    for program, count in ((PLAIN, 0), ((free, *PLAIN[1:3], rest), 2)):
        spec = scene(program, angles(30.0, 31.0), jerk(50.0, 71.7), base={"max": 20.0})
        why(spec.model_copy(update={"proof": "auto", "time_budget_s": 20.0}))
        oracle, boundaries = closed.pop()
        assert len(oracle.spec.free_parameters.parameters) == count
        assert all(each.oracle is oracle for each in boundaries)


def test_a_conflict_ends_after_some_programs_where_the_spec_gives_no_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What was not known by then says so, and what has its own time is not counted."""
    monkeypatch.setattr(conflict, "MOST_PROGRAMS", 0)
    spec = scene(PLAIN, jerk(31.0, 71.7), base={"min": 4.3})
    short = why(spec)
    assert conflict.UNTRIED in short.evidence
    assert {each.note for each in short.relaxations} == {boundary.LATE}
    timed = why(spec.model_copy(update={"time_budget_s": 3600.0}))
    assert conflict.UNTRIED not in timed.evidence
    assert all(each.needed is not None for each in timed.relaxations)


@pytest.mark.parametrize("kind", ["velocity", "jerk"])
def test_both_ends_come_near_where_no_law_keeps_the_caps(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Caps of velocity, acceleration and jerk, by the closed form V(1 − V/A − A/J) = 1 in h/βᵏ."""
    a, j = 5.3, 53.7
    v = 0.5 * a * (1.0 - a / j - sqrt((1.0 - a / j) ** 2 - 4.0 / a))
    caps = [velocity(0.996 * v, 71.3), acceleration(a, 71.3), jerk(j, 71.3)]
    monkeypatch.setattr(
        conflict,
        "relaxable_numbers",
        lambda s: [n for n in relaxable_numbers(s) if n.limit == kind],
    )
    program = [rise(71.3), dwell(37.9), fall(113.7, law="cycloidal"), dwell(137.1)]
    asked = scene(program, *caps, base=300.0).model_copy(update={"proof": "auto"})
    (found,) = why(asked).relaxations
    assert found.needed is not None
    assert found.at_least is not None
    v *= 0.996
    least = {"velocity": 1.0 / 0.996, "jerk": a / (1.0 - v / a - 1.0 / v) / j}[kind]
    assert found.at_least <= least * found.requested <= found.needed * (1.0 + 1e-9)
    assert found.needed - found.at_least <= NEAR * (found.needed - found.requested)


def test_a_member_is_left_out_by_a_proof_as_long_as_the_questions_own() -> None:
    """A quick trial without it finds neither a cam nor a proof; the question itself was proven."""
    first, second = (
        Relaxable(name, (f"limits/{n}/{name}",), (1.0,), "", "≤") for n, name in enumerate("ab")
    )

    def trial(*, certified: bool = False, proof: str = "") -> Any:
        return SimpleNamespace(certified=certified, proof=proof, on_time=True, strained=())

    class Trials:
        def is_late(self) -> bool:
            return False

        def without(self, removed: list[Relaxable]) -> Any:
            return trial(certified=first in removed)

        def proven_without(self, removed: list[Relaxable]) -> Any:
            return trial(certified=True) if first in removed else trial(proof="proven")

    for original, kept in ((trial(proof="proven"), [first]), (trial(), [first])):
        members = conflict._irreducible(cast(Oracle, Trials()), [first, second], [first], original)
        assert members.numbers == kept
        assert members.trial.proof == "proven"
        assert not members.unconfirmed


@pytest.mark.parametrize(("floor", "asked", "most"), [(0.0, 0, 8), (0.12, 1, 2)])
def test_whether_anything_suffices_is_asked_where_the_secant_ends_far_away(
    floor: float, asked: int, most: int
) -> None:
    """Two questions: the excess falls to 0, at first by half a step; and it falls to a floor."""
    tried, without = list[float](), list[Any]()

    def trial_at(value: float) -> Any:
        missing = floor + (0.2 - floor) * (1000.0 / value) ** 3 - (0.0 if floor else 0.04)
        fits = missing <= 0.0
        return SimpleNamespace(
            certified=fits, excess=missing, bound_excess=None, smallest=None, proof="", on_time=True
        )

    def relaxed_to(_number: Any, value: float, *_: Any, **_more: Any) -> Any:
        tried.append(float(value))
        return trial_at(value)

    def left_out(numbers: Any) -> Any:
        without.append(numbers)
        return SimpleNamespace(certified=False)

    oracle = SimpleNamespace(
        spec=SimpleNamespace(tolerance=5e-3, proof="auto"), open_gap=0.0, has_longer_proofs=False,
        is_late=lambda: False,
        relaxed=relaxed_to, is_valid=lambda *_: True, without=left_out,
    )  # fmt: skip
    number = Relaxable("jerk", ("limits/0/max_mm_per_s3",), (1000.0,), "mm/s³", "≤")
    known = Boundary(cast(Oracle, oracle), number, trial_at(1000.0))
    assert outwards._step_outwards(known) is not bool(floor)
    assert len(without) == asked
    assert len(tried) <= most
