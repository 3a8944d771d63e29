"""A design k times as large, or k times as fast, is the same design.

Numbers are told on the wire in mm and s, and solved without either: scaling every length by 1e-6
or 1e6, or the speed, may change no relative result beyond 1e-9, neither value nor gap nor law. Of a
flat face the optimum is that of a linear program and often not unique; so the programs are written
without their numbers' last digits, or the last bit would decide which law is found.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import Any

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from tests.hard.cases import ANGLES, FACE, RETURN, RISE, ROLLER, H, aim, jerk, moves, radius, scene

CAMS: dict[str, dict[str, Any]] = {
    "roller": scene(ANGLES, jerk(48.0)),
    "roller, curvature binding": scene(ANGLES, jerk(48.0), radius(12.0)),
    "roller, offset in a range": scene(
        ANGLES, jerk(48.0), follower=ROLLER | {"offset_mm": {"min": -6.3, "max": 4.1}},
        base_radius_mm={"min": 11.0, "max": 170.0},
    ),
    "roller, hollows for a cutter": scene(
        ANGLES, jerk(48.0), {"kind": "cutter_radius", "radius_mm": 61.0},
        program=moves(law={"kind": "cycloidal"}),
    ),
    "roller, least acceleration": scene(
        jerk(61.0), objective=aim("peak_acceleration"), base_radius_mm=200.0
    ),
    "face": scene(jerk(48.0), follower=FACE),
    "face, radius binding": scene(jerk(48.0), radius(7.3), follower=FACE),
    "face, width binding": scene(
        jerk(61.0), {"kind": "face_width", "width_mm": 95.0}, radius(2.0), follower=FACE
    ),
    "face, tilted": scene(
        jerk(48.0), radius(7.3), follower=FACE | {"tilt_deg": -6.7, "offset_mm": 3.1}
    ),
    "roller, last digits": scene(ANGLES, jerk(48.0), tolerance=1e-5),
    "roller, no dwell at the top": scene(
        jerk(61.0), objective=aim("peak_jerk"), base_radius_mm=200.0,
        program=[moves()[0], moves()[2], {"kind": "dwell", "angle_deg": 360.0 - RISE - RETURN}],
    ),
}  # fmt: skip
SETTLED = 1e-9
LENGTH = ("_mm", "_mm_per_s", "_mm_per_s2", "_mm_per_s3")
POWER = {"velocity": 1, "acceleration": 2, "jerk": 3}


def enlarged(value: Any, factor: float, key: str = "") -> Any:
    """A spec with every length times ``factor``, caps on velocity to jerk included."""
    if isinstance(value, dict):
        inherited = key if key.endswith("_mm") else ""
        return {k: enlarged(v, factor, inherited or k) for k, v in value.items()}
    if isinstance(value, list):
        return [enlarged(one, factor, key) for one in value]
    return value * factor if key.endswith(LENGTH) and isinstance(value, float) else value


def hastened(body: dict[str, Any], factor: float) -> dict[str, Any]:
    """The same at ``factor`` times the speed, caps on velocity to jerk along with it."""
    limits = [
        {
            key: value * factor ** POWER[limit["kind"]] if "_per_s" in key else value
            for key, value in limit.items()
        }
        for limit in body["limits"]
    ]
    return body | {"speed_rpm": body["speed_rpm"] * factor, "limits": limits}


@lru_cache(maxsize=64)
def made(name: str, factor: float = 1.0, haste: float = 1.0) -> Design:
    # from a lift of 1 mm: the wire takes 1e-6 to 1e6 mm
    body = hastened(enlarged(enlarged(CAMS[name], 1.0 / H), factor), haste)
    return synthesise(DesignSpec.model_validate(body))


def power_of_time(name: str) -> int:
    """n where an objective's value goes with ω^n, from its unit."""
    _, per_s, order = name.partition("_per_s")
    return int(order or 1) if per_s else 0


def assert_same(found: Design, wanted: Design, factor: float, haste: float = 1.0) -> None:
    """Every relative result agrees to 1e-9."""
    assert found.status == wanted.status
    length = wanted.dimensions["base_radius_mm"]
    for key, value in wanted.dimensions.items():
        scale = factor if key.endswith("_mm") else 1.0
        assert found.dimensions[key] / scale == pytest.approx(value, rel=1e-9, abs=1e-9 * length)
    for key, value in wanted.objectives.items():
        scale = factor * haste ** power_of_time(key)
        assert found.objectives[key] / scale == pytest.approx(value, rel=1e-9)
    for a, b in zip(found.motion, wanted.motion, strict=True):
        if b.spline is not None:
            assert a.spline is not None
            x = np.linspace(0.0, 1.0, 201)
            ours, theirs = (
                design.curve.derivatives(np.radians(m.start_deg + x * m.angle_deg), 0)[0]
                for design, m in ((found, a), (wanted, b))
            )
            lift = abs(b.levels[1] - b.levels[0])
            # a law that nothing presses on is one of many, found to the solver's tolerance
            np.testing.assert_allclose(ours / factor, theirs, rtol=0, atol=1e-7 * lift)
    if wanted.certificate.gap is not None:
        assert found.certificate.gap == pytest.approx(wanted.certificate.gap, abs=1e-9)
    verdicts = [[(e.limit, e.holds) for e in design.extremes] for design in (found, wanted)]
    assert verdicts[0] == verdicts[1]


@pytest.mark.parametrize("factor", [1e-6, 1e6])
@pytest.mark.parametrize("name", CAMS)
def test_every_length_scaled(name: str, factor: float) -> None:
    assert_same(made(name, factor), made(name), factor)


@pytest.mark.parametrize("haste", [1e-5, 7.3, 1e4])
@pytest.mark.parametrize("name", ["roller", "roller, curvature binding", "face, radius binding"])
def test_speed_changes_nothing_but_times(name: str, haste: float) -> None:
    found, wanted = made(name, 1.0, haste), made(name)
    assert_same(found, wanted, 1.0, haste)
    assert found.speed_rpm == pytest.approx(wanted.speed_rpm * haste)


def test_without_any_rate_in_the_spec_speed_changes_no_digit() -> None:
    body = scene(ANGLES, program=moves(law={"kind": "cycloidal"}))
    slow, fast = (
        synthesise(DesignSpec.model_validate(body | {"speed_rpm": rpm})) for rpm in (pi, 1e4 * pi)
    )
    assert slow.dimensions == fast.dimensions
