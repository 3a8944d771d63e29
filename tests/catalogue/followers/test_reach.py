"""What an arm reaches, against brute force over pivots, angles and radii."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic_core import PydanticCustomError

from synthesis.catalogue.followers.arm_workspace import ArmGeometry
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.motion import FreeLaw, PlacedSegment
from synthesis.numerics.geometry.plane import enclosed_angle, third_side
from synthesis.numerics.piecewise import Piecewise
from tests.numerics.geometry.cams import unspecial

STILL = Piecewise.of([0.0, 1.0], [[0.0]])
INF = float("inf")


def program(lift: float, law: str | None = "cycloidal") -> tuple[PlacedSegment, ...]:
    """A rise of 1.3 rad, a dwell, a return of 2.1 rad."""
    rise, back = (None, None) if law is None else (LAWS[law].curve(k) for k in ("rise", "return"))
    free = FreeLaw(2, False) if law is None else None
    return (
        PlacedSegment(0, "rise", 0.0, 1.3, 0.0, lift, rise, free),
        PlacedSegment(1, "dwell", 1.3, 0.7, lift, lift, STILL),
        PlacedSegment(2, "return", 2.0, 2.1, lift, 0.0, back, free),
    )


def refused(arm: ArmGeometry, prime: tuple[float, float], lift: float = 0.0) -> str:
    """Which rule refuses it; '' if none does."""
    try:
        arm.check(prime, program(lift))
    except PydanticCustomError as error:
        return error.type
    return ""


@given(unspecial(0.1, 3.0), unspecial(0.1, 3.0), unspecial(0.001, 3.14))
def test_sides_and_angle_of_a_triangle(a: float, b: float, angle: float):
    side = third_side(a, b, angle)
    assert side == pytest.approx(abs(a - b * np.exp(1j * angle)), rel=1e-9, abs=1e-12)
    assert enclosed_angle(a, b, side) == pytest.approx(angle, rel=1e-9, abs=1e-7)


@pytest.mark.parametrize(("side", "angle"), [(0.3, 0.0), (0.0, 0.0), (5.1, np.pi), (9.0, np.pi)])
def test_where_there_is_no_triangle(side: float, angle: float):
    assert enclosed_angle(2.0, 3.0, side) == angle


def test_a_small_angle_keeps_its_digits():
    # the law of cosines itself would lose all of them
    angle = 1e-9
    assert third_side(1e3, 1e3, angle) == pytest.approx(1e-6, rel=1e-12)
    assert enclosed_angle(1e3, 1e3, 1e-6) == pytest.approx(angle, rel=1e-12)


@given(
    unspecial(0.2, 3.0), unspecial(0.1, 2.0), unspecial(0.0, 3.0), unspecial(0.05, 4.0),
    unspecial(0.0, 2.0), st.sampled_from(["number", "range", "open"]),
)  # fmt: skip
def test_a_triangle_is_refused_only_where_there_is_none(
    length: float, d0: float, more: float, R0: float, wider: float, pivot: str
):
    distance = {"number": (d0, d0), "range": (d0, d0 + more), "open": (d0, INF)}[pivot]
    arm = ArmGeometry(length, distance, (-INF, INF), 0.0)
    prime = (R0, R0 + wider)
    d = np.linspace(d0, min(distance[1], length + prime[1] + 1.0), 1500)[:, None]
    R = np.linspace(*prime, 1500)
    gap = np.minimum(R - abs(length - d), length + d - R)
    best = float(np.max(gap))
    if abs(best) > 5e-3:  # nearer than the grid can tell
        assert refused(arm, prime) == ("" if best > 0.0 else "arm_does_not_reach")


@given(unspecial(0.4, 2.0), unspecial(0.3, 1.2), unspecial(0.1, 3.5), unspecial(0.0, 0.8))
def test_a_swing_is_refused_where_the_smallest_radius_has_no_room(
    length: float, angle: float, swing: float, wider: float
):
    arm = ArmGeometry(length, (1.0, 1.0), (-INF, INF), 0.0)
    prime = third_side(length, 1.0, angle), third_side(length, 1.0, angle) * (1.0 + wider)
    reported = refused(arm, prime, length * swing)
    assert reported == ("swing_too_large" if angle + swing >= np.pi else "")
    if not reported:
        low, high = arm.prime_radii_for(prime, length * swing)
        assert low == prime[0]
        largest = enclosed_angle(length, 1.0, high)
        assert largest + swing <= np.pi * (1.0 + 1e-9)
        assert high == prime[1] or largest + swing == pytest.approx(np.pi, rel=1e-9)


@pytest.mark.parametrize("law", ["cycloidal", "parabolic", "modified_sine", None])
def test_the_cam_angle_is_where_the_law_gets_there(law: str | None):
    length, angle, swing = 0.9, 1.1, 2.6
    arm = ArmGeometry(length, (1.0, 1.0), (angle, angle), 0.0)
    prime = (third_side(length, 1.0, angle),) * 2
    with pytest.raises(PydanticCustomError) as caught:
        arm.check(prime, program(length * swing, law))
    at = np.radians(caught.value.context["at"])
    if law is None:
        assert at == pytest.approx(1.3, abs=1e-6)
    else:
        reached = swing * LAWS[law].curve("rise")(at / 1.3)
        assert reached == pytest.approx(np.pi - angle, abs=1e-5)
    assert caught.value.context["swing"] == pytest.approx(np.degrees(np.pi - angle), abs=1e-6)


def test_an_angle_that_contradicts_the_radius_is_refused_and_one_that_agrees_is_not():
    length, angle = 0.9, 1.1
    prime = third_side(length, 1.0, angle)
    arm = ArmGeometry(length, (1.0, 1.0), (angle, angle), 0.0)
    assert refused(arm, (prime, prime)) == ""
    assert refused(arm, (prime * (1.0 + 1e-6),) * 2) == "initial_angle_contradicts"
    assert refused(arm, (prime * (1.0 - 1e-6),) * 2) == "initial_angle_contradicts"
    assert refused(arm, (prime * 0.9, prime * 1.1)) == ""
