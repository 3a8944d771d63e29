"""The certificate of every follower family, and of free laws, stands to 25 digits."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from service.contract.examples import examples
from synthesis import Confirmation, Design, DesignSpec, confirm, synthesise
from synthesis.catalogue.followers.base import paths
from synthesis.units import DEGREE
from tests.catalogue.followers.samples import CASES, spec
from tests.hard import cases

FREE = ["example-13-6-sized", "conjugate", "oscillating-roller", "tilted-flat-face",
        "windows-and-points", "table"]  # fmt: skip
HARD = {
    name: cases.CASES[name]
    for name in (
        "rise of 1°", "dwell of 0° everywhere", "undercut exactly on the border",
        "jerk cap exactly a given law's", "acceleration cap on constant velocity",
        "offset nearly the prime radius, steep",
    )
}  # fmt: skip


def designed(name: str) -> Design:
    body = HARD[name].spec if name in HARD else examples()[name]["value"]
    return synthesise(DesignSpec.model_validate(body | {"proof": "quick"}))


def assert_confirmed(design: Design, found: Confirmation) -> None:
    wrong = [line for line in found.lines if line.agrees is not True]
    assert not wrong, wrong
    assert found.verdict == "confirmed"
    assert [line.limit for line in found.lines] == [extreme.limit for extreme in design.extremes]


@pytest.mark.parametrize(("kind", "sample"), CASES)
def test_given_cams_of_every_family(kind: str, sample: int) -> None:
    design = synthesise(spec(kind, sample))
    assert_confirmed(design, confirm(design))


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("name", [*FREE, *HARD])
def test_free_laws(name: str) -> None:
    design = designed(name)
    found = confirm(design)
    assert_confirmed(design, found)
    for line, extreme in zip(found.lines, design.extremes, strict=True):
        if line.how.startswith("branch and bound") and line.value is not None:
            # the enclosure of the one holds the value of the other, whose own is far narrower
            assert extreme.value is not None
            assert line.width is not None
            rounding = 1e-14 * abs(extreme.value)
            assert abs(float(line.value) - extreme.value) <= extreme.width + rounding + 1e-9 * (
                "window" in line.limit or "point" in line.limit
            )
            assert line.width <= 1e-22 * max(1.0, abs(extreme.value))


@pytest.mark.parametrize(("kind", "sample"), CASES)
def test_the_link_is_the_follower(kind: str, sample: int) -> None:
    """At rest, and moved as a rigid body, its points and faces are those that the family traces."""
    design = synthesise(spec(kind, sample))
    follower, z = design.completed_spec.follower, tuple(design.size)
    link = follower.link(z, DEGREE)
    for s in (0.0, 3.7):
        still = (s, 0.0, 0.0, 0.0)
        for path, trace in paths(follower).items():
            (x, y), *_ = trace.position(still, z)
            if link.face is not None:
                normal = moved(link, link.face.normal, s / follower.travel.per_unit, turned=True)
                at = moved(link, link.face.at, s / follower.travel.per_unit)
                found = (x - at[0]) * normal[0] + (y - at[1]) * normal[1]
                assert abs(found) < 1e-12 * 200.0
                assert normal == pytest.approx(trace.normal((0.0, 0.0), still, z), abs=1e-13)
                continue
            tip = next(tip for tip in link.tips if tip.path == path)
            assert moved(link, tip.at, s / follower.travel.per_unit) == pytest.approx(
                (float(x), float(y)), abs=1e-11
            )


def moved(
    link: object, point: tuple[float, float], travel: float, *, turned: bool = False
) -> tuple[float, float]:
    """A point of the link after some travel in the unit of the wire; with ``turned``, a vector."""
    if link.pivot is None:
        shift = (0.0, 0.0) if turned else link.slide
        return point[0] + travel * shift[0], point[1] + travel * shift[1]
    angle = link.turn * travel * pi / 180.0
    px, py = (0.0, 0.0) if turned else link.pivot
    x, y = point[0] - px, point[1] - py
    cos, sin = np.cos(angle), np.sin(angle)
    return px + x * cos - y * sin, py + y * cos + x * sin
