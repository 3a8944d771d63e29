"""The least peak of the pressure angle on arms, against searches that know nothing of bounds."""

from __future__ import annotations

from math import atan, degrees, pi, radians
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis import Design, DesignSpec, synthesise
from tests.optimise.arms import ARM, FALL, RISE, SENSES, SWING, jerk, least, scene, slope
from tests.pipeline.test_oscillating_flat_face import RADIUS, dense, question

PEAK: dict[str, Any] = {"kind": "peak_pressure_angle"}
LARGEST, ROLLER, DISTANCE = 24.3, 7.9, 101.9


def value(design: Design) -> float:
    return design.objectives["peak_pressure_angle_deg"]


def certified(design: Design) -> bool:
    return design.certificate.certified and all(extreme.holds for extreme in design.extremes)


def steepest(psi0: np.ndarray, distance: Any, sense: str, count: int) -> np.ndarray:
    """The largest |tan α| of the cycloidal scene, from the instant centre; ∞ past dead centre."""
    x = np.linspace(0.0, 1.0, count)[:, None]
    g, rate, swing = (
        x - np.sin(2.0 * pi * x) / (2.0 * pi),
        1.0 - np.cos(2.0 * pi * x),
        radians(SWING),
    )
    up = slope(psi0 + swing * g, swing / radians(RISE) * rate, distance, sense)
    down = slope(psi0 + swing * (1.0 - g), -swing / radians(FALL) * rate, distance, sense)
    largest = np.maximum(np.max(np.abs(up), axis=0), np.max(np.abs(down), axis=0))
    return np.where(psi0 + swing < pi, largest, np.inf)


def searched(sense: str, distance: float | None, largest: float) -> float:
    """The least peak [deg] over ψ0, and d, by differential evolution."""

    def worth(points: np.ndarray, count: int) -> np.ndarray:
        d = distance or points[1]
        prime = np.sqrt(d * d + ARM * ARM - 2.0 * d * ARM * np.cos(points[0]))
        excess = np.maximum(prime - ROLLER - largest, 0.0)
        return steepest(points[0], d, sense, count) + 1e3 * excess

    bounds = [(0.01, 2.5), (0.4 * ARM, 2.5 * ARM)][: 1 if distance else 2]
    return degrees(atan(least(worth, bounds)))


@pytest.mark.parametrize(
    ("sense", "distance", "largest"),
    [
        ("opposite", DISTANCE, LARGEST), ("same", DISTANCE, LARGEST), ("same", DISTANCE, None),
        ("opposite", None, LARGEST),
    ],
)  # fmt: skip
def test_given_law_as_flat_as_a_global_search_finds(
    sense: str, distance: float | None, largest: float | None
) -> None:
    """The base radius at its end; inside, where a larger cam is no better; the pivot free too."""
    limit = {} if largest is None else {"base_radius_mm": {"max": largest}}
    design = synthesise(
        scene(law="cycloidal", sense=sense, distance=distance, objective=PEAK, **limit)
    )
    assert design.status == "optimal"
    assert certified(design)
    assert design.certificate.bound_valid_for == "every size of the given laws"
    assert value(design) == pytest.approx(searched(sense, distance, largest or 1e9), rel=2e-6)
    base = design.dimensions["base_radius_mm"]
    assert (base == pytest.approx(largest, rel=1e-5)) if largest else base > 1.2 * LARGEST


def test_mirrored_and_enlarged_it_is_the_same() -> None:
    one = synthesise(scene(law="cycloidal", distance=DISTANCE, objective=PEAK))
    turned = synthesise(scene(law="cycloidal", distance=DISTANCE, objective=PEAK, rotation="cw"))
    large = synthesise(
        scene(law="cycloidal", distance=1e3 * DISTANCE, objective=PEAK, scale=1e3)
    )  # fmt: skip
    assert value(turned) == value(one)
    assert value(large) == pytest.approx(value(one), rel=1e-7)


@pytest.fixture(scope="module")
def free() -> Design:
    return synthesise(
        scene(jerk(1.9), distance=DISTANCE, base_radius_mm={"max": 20.3}, objective=PEAK,
              tolerance=2e-2)
    )  # fmt: skip


def test_a_free_law_is_bounded_over_all_laws(free: Design) -> None:
    assert free.status == "optimal"
    assert certified(free)
    assert free.certificate.bound_valid_for == "all motion laws with a bounded jerk"
    assert free.certificate.lower_bound is not None
    assert 0.97 * value(free) <= free.certificate.lower_bound <= value(free)
    given = synthesise(
        scene(law="modified_sine", distance=DISTANCE, base_radius_mm={"max": 20.3}, objective=PEAK)
    )
    assert value(given) > 1.02 * value(free)


@pytest.mark.usefixtures("unexplained")
def test_what_is_asked_of_the_angle_is_what_came_out_of_it(free: Design) -> None:
    """The smallest cam under the least angle is as large as allowed, below the bound larger."""

    def smallest(angle: float) -> Design:
        limit = {"kind": "pressure_angle", "rise_deg": angle, "return_deg": angle}
        return synthesise(scene(jerk(1.9), limit, distance=DISTANCE, tolerance=1e-2))

    assert free.certificate.lower_bound is not None
    at, below = smallest(value(free) * 1.0001), smallest(free.certificate.lower_bound * 0.995)
    assert at.dimensions["base_radius_mm"] == pytest.approx(20.3, rel=2e-2)
    assert at.dimensions["base_radius_mm"] <= 20.3 * (1.0 + 1e-2)
    assert not below.motion or below.dimensions["base_radius_mm"] > 20.3


def test_the_angle_first_and_the_size_within_what_it_may_lose() -> None:
    design = synthesise(
        scene(law="cycloidal", distance=DISTANCE, objective=[PEAK, {"kind": "base_radius"}],
              tolerance=2e-2)
    )  # fmt: skip
    alone = synthesise(scene(law="cycloidal", distance=DISTANCE, objective=PEAK))
    assert certified(design)
    assert value(alone) <= value(design) <= value(alone) * 1.021
    assert design.dimensions["base_radius_mm"] < 0.95 * alone.dimensions["base_radius_mm"]


# -- a swinging face ---------------------------------------------------------------------------


def steepest_of_a_face(spec: DesignSpec, turn: Any, base: float, distance: float) -> float:
    """Peak angle [deg] of a face, by f / r with r from the instant centre; 90° where undercut."""
    _, (phi, rate, bend), sign = turn
    follower = spec.follower.model_dump()
    f, sigma = follower["face_offset_mm"], SENSES[follower["sense"]]
    psi, w = np.arcsin((base + f) / distance) + phi, 1.0 + sigma * rate
    h, r = distance * np.sin(psi) - f, distance * np.cos(psi) / w
    radius = h + distance * ((np.cos(psi) * bend - np.sin(psi) * rate**2) / w**2
                             - np.cos(psi) * rate * sigma * bend / w**3)  # fmt: skip
    if np.min(radius) < 4.1 or np.min(np.cos(psi)) <= 0.0:
        return 90.0
    return float(np.max(np.degrees(np.arctan2(f, r))[sign != 0.0]))


@pytest.mark.parametrize("sense", SENSES)
def test_a_face_as_flat_as_a_scan_of_its_base_radius_finds(sense: str) -> None:
    spec = question(71.3, RADIUS, sense=sense, objective=PEAK)
    design = synthesise(spec)
    assert design.status == "optimal"
    assert certified(design)
    base, turn = design.dimensions["base_radius_mm"], dense(spec, 1501)
    assert value(design) == pytest.approx(steepest_of_a_face(spec, turn, base, 71.3), rel=1e-5)
    others = [steepest_of_a_face(spec, turn, other, 71.3) for other in np.linspace(0.5, 65.0, 130)]
    assert value(design) <= min(others) * (1.0 + 1e-6)
    assert steepest_of_a_face(spec, turn, base - 0.05, 71.3) > value(design)


def test_a_face_with_its_pivot_free_is_flattest_far_away() -> None:
    design = synthesise(question({"max": 93.7}, RADIUS, objective=PEAK, tolerance=2e-2))
    given = synthesise(question(93.7, RADIUS, objective=PEAK))
    assert design.status == "optimal"
    assert value(design) == pytest.approx(value(given), rel=1e-4)
    assert design.dimensions["centre_distance_mm"] == pytest.approx(93.7, rel=1e-3)


def test_a_face_that_points_at_its_pivot_has_nothing_to_weigh() -> None:
    with pytest.raises(ValidationError) as refused:
        question(71.3, RADIUS, offset=0.0, objective=PEAK)
    assert refused.value.errors()[0]["type"] == "pressure_angle_given"


def test_without_an_end_to_the_size_there_is_no_best() -> None:
    with pytest.raises(ValidationError) as refused:
        scene(law="cycloidal", objective=PEAK)
    assert refused.value.errors()[0]["type"] == "no_best_pressure_angle"
