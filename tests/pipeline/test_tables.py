"""Tables as segments, all the way to the certificate."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis import Design, DesignSpec, analyse, confirm, synthesise
from synthesis.catalogue.laws import LAWS

RNG = np.random.default_rng(5)
OMEGA = 71.0 * pi / 30.0


def rows(kind: str, angle: float, lift: float, count: int, noise: float) -> list[list[float]]:
    """Noisy readings of a known law at uneven angles, counted from an arbitrary level."""
    x = np.sort(np.concatenate([[0.0, 1.0], RNG.uniform(0.0, 1.0, count - 2)]))
    s = 17.3 + lift * LAWS[kind].curve("rise")(x) + RNG.uniform(-noise, noise, count)
    return np.stack([angle * x, s], axis=1).tolist()


def table(angle: float, lift: float, noise: float = 3e-4, **changes: Any) -> dict[str, Any]:
    body: dict[str, Any] = {
        "kind": "table", "angle_deg": angle, "tolerance_mm": 5e-4, "lift_mm": lift,
        "points": rows("modified_sine", angle, lift, 211, noise),
    }  # fmt: skip
    return body | changes


def spec(program: list[dict[str, Any]], **changes: Any) -> DesignSpec:
    body: dict[str, Any] = {
        "speed_rpm": 71.0,
        "program": program,
        "follower": {"kind": "translating_roller", "roller_radius_mm": 8.3, "offset_mm": 2.7},
        "limits": [{"kind": "pressure_angle", "rise_deg": 33.0, "return_deg": 37.0}],
        "tolerance": 1e-2,
    }
    return DesignSpec.model_validate(body | changes)


def extremes(design: Any) -> dict[str, Any]:
    return {extreme.limit: extreme for extreme in design.extremes}


def measured(design: Design, index: int = 0) -> float:
    """How far the motion passes the rows of a table, with the spec's own numbers."""
    segment, motion = design.spec.program[index], design.motion[index]
    degrees, s = np.array(segment.points).T
    found = design.curve.derivatives(np.radians(motion.start_deg + degrees), 0)[0]
    middle = (s[0] + s[-1]) / 2.0
    return float(np.abs(found - (motion.s_start_mm + motion.s_end_mm) / 2.0 - s + middle).max())


DWELLS = [{"kind": "dwell", "angle_deg": 31.0}, {"kind": "dwell", "angle_deg": 133.2}]


def test_a_table_between_dwells_beside_a_spline() -> None:
    fall = {"kind": "return", "angle_deg": 92.1, "lift_mm": 28.4, "law": {"kind": "spline"}}
    jerk = {"kind": "jerk", "max_mm_per_s3": 4e5}
    program = [table(103.7, 28.4), DWELLS[0], fall, DWELLS[1]]
    question = spec(program, limits=[{"kind": "pressure_angle", "rise_deg": 33.0}, jerk])
    design = synthesise(question)
    assert design.status == "optimal"
    deviation = extremes(design)["table_deviation"]
    assert deviation.value == pytest.approx(measured(design), abs=1e-9)
    assert deviation.value <= 5e-4 == deviation.bound
    assert deviation.field == "program/0/tolerance_mm"
    assert (design.motion[0].kind, design.motion[0].law) == ("rise", "table")
    for share, verdict in ((0.5e-9, "confirmed"), (1e-7, "contradicted")):
        moved = deviation.model_copy(update={"value": deviation.value + share * 5e-4})
        lines = [moved if line is deviation else line for line in design.extremes]
        assert confirm(design.model_copy(update={"extremes": lines})).verdict == verdict
    unbounded = deviation.model_copy(update={"bound": None})
    assert confirm(design.model_copy(update={"extremes": [unbounded]})).verdict == "incomplete"
    stage = design.report.stages[0]
    assert (stage.stage, stage.solver) == ("table program/0", "Clarabel")
    again = Design.model_validate_json(design.model_dump_json())
    theta = np.linspace(0.0, 2.0 * pi, 777)
    assert np.array_equal(again.curve.derivatives(theta), design.curve.derivatives(theta))


def test_a_table_joins_a_constant_velocity() -> None:
    """v = lift/β of the straight segment on both sides, no jump up to the acceleration."""
    line = {"kind": "constant_velocity", "angle_deg": 41.3, "lift_mm": 19.9}
    x = np.linspace(0.0, 1.0, 131)
    v = 19.9 / 41.3 * 66.1  # per unit of x
    curve = LAWS["polynomial_5"].with_end_derivatives("rise", (0.0, 0.0), (v / 23.7, 0.0))
    points = np.stack([66.1 * x, 23.7 * curve(x) + RNG.uniform(-2e-4, 2e-4, 131)], axis=1).tolist()
    law = {"kind": "polynomial_5", "overshoot": True}  # it still rises where it begins
    fall = {"kind": "return", "angle_deg": 141.1, "lift_mm": 43.6, "law": law}
    program = [
        {"kind": "table", "angle_deg": 66.1, "tolerance_mm": 5e-4, "lift_mm": 23.7,
         "points": points}, line, fall, {"kind": "dwell", "angle_deg": 111.5},
    ]  # fmt: skip
    found = synthesise(spec(program, continuity=2))
    assert found.certificate.certified
    near = found.curve.curve.breaks[np.argmin(abs(found.curve.curve.breaks - np.radians(66.1)))]
    left, right = (found.curve.derivatives([near], 2, side)[:, 0] for side in ("left", "right"))
    assert left == pytest.approx(right, abs=1e-8)
    assert right[1] == pytest.approx(19.9 / np.radians(41.3), rel=1e-9)


def whole_turn(count: int, noise: float) -> list[list[float]]:
    """A harmonic motion that moves both ways: (1 − cos θ) 11.3 mm with a second harmonic."""
    degrees = 360.0 * np.arange(count) / count
    theta = np.radians(degrees)
    s = 11.3 * (1.0 - np.cos(theta)) + 1.7 * np.sin(2.0 * theta) + 4.0
    return np.stack([degrees, s + RNG.uniform(-noise, noise, count)], axis=1).tolist()


def test_a_table_of_a_whole_turn_closes_and_is_held_to_both_pressure_angles() -> None:
    segment = {"kind": "table", "angle_deg": 360.0, "tolerance_mm": 2e-4,
               "points": whole_turn(720, 1e-4)}  # fmt: skip
    design = synthesise(spec([segment], continuity=4))
    assert design.status == "optimal"
    assert design.motion[0].kind == "table"
    found = extremes(design)
    assert max(found["pressure_angle_rise"].value, 0.0) <= 33.0
    assert {"pressure_angle_rise", "pressure_angle_return", "snap_join"} <= set(found)
    theta = np.radians(np.linspace(0.0, 360.0, 1001))
    s, v = design.curve.derivatives(theta, 1)
    assert s.min() >= -2e-4
    expected = 11.3 * np.sin(theta) + 3.4 * np.cos(2.0 * theta)
    assert np.abs(v - expected).max() <= 5e-3


def test_seven_thousand_rows_with_a_tenth_of_a_micrometre_of_noise() -> None:
    segment = {"kind": "table", "angle_deg": 360.0, "tolerance_mm": 2e-4,
               "points": whole_turn(7200, 1e-4)}  # fmt: skip
    found = analyse(spec([segment], base_radius_mm=70.0, limits=[]))
    assert found.holds, found.violated
    assert extremes(found)["table_deviation"].value <= 2e-4


def test_columns_say_the_same_as_rows() -> None:
    points = rows("cycloidal", 99.0, 20.0, 41, 1e-4)
    degrees, s = np.array(points).T.tolist()
    common = {"kind": "table", "angle_deg": 99.0, "tolerance_mm": 1e-3, "lift_mm": 20.0}
    fall = {"kind": "return", "angle_deg": 261.0, "lift_mm": 20.0, "law": {"kind": "cycloidal"}}
    one, other = (
        spec([common | given, fall]).placed_segments()[0].table
        for given in ({"points": points}, {"angles_deg": degrees, "displacements_mm": s})
    )
    assert one is not None
    assert other is not None
    assert np.array_equal(one.s, other.s)
    assert np.array_equal(one.x, other.x)


@pytest.mark.usefixtures("unexplained")
def test_a_tolerance_that_is_missed_is_a_result() -> None:
    program = [table(103.7, 28.4), DWELLS[0],
               {"kind": "return", "angle_deg": 92.1, "lift_mm": 28.4, "law": {"kind": "cycloidal"}},
               DWELLS[1]]  # fmt: skip
    at = 100
    points = [list(row) for row in program[0]["points"]]
    points.insert(at, [points[at][0] - 1e-7, points[at][1] + 0.05])
    program[0] = program[0] | {"points": points}
    design = synthesise(spec(program))
    assert design.status == "unsolved"
    deviation = extremes(design)["table_deviation"]
    assert not deviation.holds
    assert 0.02 <= deviation.value <= 0.03
    assert deviation.angle_deg == pytest.approx(points[at][0], abs=1e-3)
    assert design.conflict is not None
    assert "table deviation" in design.conflict.limits


@pytest.mark.parametrize(
    ("lift", "kind"), [(28.4, "rise"), (-28.4, "return")],
)  # fmt: skip
def test_a_table_that_moves_one_way_is_a_rise_or_a_return(lift: float, kind: str) -> None:
    law = {"kind": "cycloidal"}
    back = {"kind": "return" if lift > 0.0 else "rise", "angle_deg": 256.3, "law": law}
    question = spec([table(103.7, lift), back | {"lift_mm": abs(lift)}])
    assert question.placed_segments()[0].kind == kind
    assert list(question.left_free()) == [("/base_radius_mm", None)]


def test_a_table_is_a_value_like_any_other() -> None:
    """Equal if it says the same, read again if it is changed."""
    fall = {"kind": "return", "angle_deg": 260.0, "lift_mm": 20.0, "law": {"kind": "cycloidal"}}
    question, again = spec([wrong(), fall]), spec([wrong(), fall])
    assert question == again
    assert question.lifts() == [20.0, -20.0]
    longer = question.program[0].model_copy(update={"lift_mm": 20.0005})
    assert longer.signed_lift == 20.0005
    assert longer != question.program[0]


def test_displacement_counts_from_the_lowest_row() -> None:
    degrees = np.arange(0.0, 360.0, 2.0)
    s = 5.0 * np.sin(np.radians(degrees))
    points = np.stack([degrees, s], axis=1).tolist()
    question = spec([{"kind": "table", "angle_deg": 360.0, "tolerance_mm": 1e-3, "points": points}])
    assert question.stroke() == pytest.approx(10.0)
    assert question.placed_segments()[0].s_start == pytest.approx(5.0)


def test_states_asked_for_are_met() -> None:
    program = [
        table(103.7, 28.4, end={"velocity_mm_per_s": 0.0, "acceleration_mm_per_s2": -1500.0}),
        {"kind": "return", "angle_deg": 256.3, "lift_mm": 28.4, "law": {"kind": "polynomial_5"},
         "start": {"velocity_mm_per_s": 0.0, "acceleration_mm_per_s2": -1500.0}},
    ]  # fmt: skip
    found = analyse(spec(program, base_radius_mm=70.0, continuity=2, limits=[]))
    assert found.holds, found.violated
    assert extremes(found)["acceleration_required"].value <= 1e-4


def wrong(**changes: Any) -> dict[str, Any]:
    points = [[0.0, 0.0], [20.0, 3.0], [45.0, 9.0], [80.0, 19.0], [100.0, 20.0]]
    body = {"kind": "table", "angle_deg": 100.0, "tolerance_mm": 1e-3, "points": points}
    return body | changes


def row(at: int, *values: float) -> dict[str, Any]:
    points = wrong()["points"]
    points[at] = list(values)
    return {"points": points}


@pytest.mark.parametrize(
    ("changes", "kind", "words"),
    [
        (row(2, 15.0, 9.0), "table_order", "15.0° in row 2 does not come after the 20.0°"),
        (row(2, 20.0, 9.0), "table_order", "Remove one of the two rows"),
        (row(4, 101.0, 9.0), "table_outside", "101.0° in row 4"),
        (row(0, -1.0, 9.0), "table_outside", "-1.0° in row 0"),
        (row(0, 1.0, 9.0), "table_ends", "row 0 should be 0.0°"),
        (row(4, 99.0, 9.0), "table_ends", "row 4 should be 100.0°"),
        (row(3, 80.0, float("nan")), "finite_number", "finite"),
        (row(3, float("inf"), 3.0), "finite_number", "finite"),
        ({"points": wrong()["points"][:3]}, "table_size", "3 rows"),
        ({"points": None}, "table_columns", "Give one of the two"),
        ({"angles_deg": [0.0, 1.0]}, "table_columns", "Give one of the two"),
        ({"points": None, "angles_deg": [0.0, 1.0]}, "table_columns", "Give one of the two"),
        ({"points": None, "angles_deg": [0.0, 1.0], "displacements_mm": [0.0]}, "table_columns",
         "2 angles_deg stand beside 1 displacements"),
        ({"lift_mm": 21.0}, "table_lift", "Correct the lift"),
        ({"tolerance_mm": 15.0}, "table_still", "Use a dwell"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_with_its_row(
    changes: dict[str, Any], kind: str, words: str
) -> None:
    fall = {"kind": "return", "angle_deg": 260.0, "lift_mm": 20.0, "law": {"kind": "cycloidal"}}
    with pytest.raises(ValidationError) as caught:
        spec([wrong(**changes), fall])
    (error,) = caught.value.errors()
    assert error["type"] == kind
    assert words in error["msg"]
    if kind == "finite_number":
        assert error["loc"][:4] == ("program", 0, "points", 3)


def test_the_sum_of_the_lifts_still_has_to_be_zero() -> None:
    fall = {"kind": "return", "angle_deg": 260.0, "lift_mm": 21.0, "law": {"kind": "cycloidal"}}
    with pytest.raises(ValidationError, match="sum to zero"):
        spec([wrong(), fall])
