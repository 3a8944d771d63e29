"""What every follower family has to keep, whichever it is: over the registry, one sample each."""

from __future__ import annotations

import csv
import io
import json
from typing import get_args

import numpy as np
import pytest

from synthesis import DesignSpec, analyse, synthesise
from synthesis.catalogue.followers import FOLLOWERS, Follower
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.design.analysis import Over
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers import samples
from tests.catalogue.followers.samples import CASES, LIFTS, SAMPLES, spec
from tests.exporters.written import coarse, written
from tests.numerics.geometry.agreement import agree
from tests.numerics.geometry.slopes import slopes

NAMES = ("displacement", "velocity", "acceleration", "jerk")
family = pytest.mark.parametrize(("kind", "sample"), CASES)


def profile(question: DesignSpec, theta: np.ndarray) -> CamProfile:
    cam = given_cam(question)
    return cam_profile(cam.motion, question.follower, cam.size, question.rotation, theta)


def per_unit(question: DesignSpec) -> float:
    """The core's mm in one unit of the wire's displacement: an arc at arm or centre distance."""
    reported = question.follower.model_dump()
    arm = reported.get("arm_mm", reported.get("centre_distance_mm"))
    return 1.0 if arm is None else arm * np.pi / 180.0


@pytest.mark.parametrize("table", ["SAMPLES", "LIFTS", "BODIES"])
def test_every_family_is_in_the_tables_of_the_tests(table: str) -> None:
    kinds = {family.model_fields["kind"].default for family in FOLLOWERS}
    missing = kinds - set(getattr(samples, table))
    assert not missing, f"add {missing} to {table} in {samples.__file__}"


@pytest.mark.parametrize("family", [f for f in FOLLOWERS if "closure" in f.model_fields])
def test_every_closure_of_a_family_has_a_sample(family: type[Follower]) -> None:
    """So that geometry, certificate, second judge and every format meet each of them."""
    kind = family.model_fields["kind"].default
    choices = get_args(family.model_fields["closure"].annotation)
    closures = {choice.model_fields["kind"].default for choice in choices}
    met = {spec(kind, number).follower.closure.kind for number in range(len(SAMPLES[kind]))}
    assert closures, f"{kind} has no closures"
    assert closures <= met, f"add samples with {closures - met} to SAMPLES[{kind!r}]"


@family
def test_it_goes_over_the_wire_and_back(kind: str, sample: int) -> None:
    question = spec(kind, sample)
    assert DesignSpec.model_validate_json(question.model_dump_json()) == question
    assert question.follower.size_names in type(question.follower).size_charts
    assert len(given_cam(question).size) == len(question.follower.size_names)
    assert not list(question.left_free())
    reported = question.follower.dimensions(given_cam(question).size)
    assert reported["base_radius_mm"] == pytest.approx(SAMPLES[kind][sample][1], rel=1e-12)


@family
def test_the_traced_point_s_derivatives_are_those_of_its_position(kind: str, sample: int) -> None:
    question = spec(kind, sample)
    cam, theta = given_cam(question), np.radians([17.3, 61.9, 120.1, 171.7, 229.9, 301.3])
    reach = np.full(len(theta), 0.02)

    def traced(angle: np.ndarray) -> np.ndarray:
        found = question.follower.position(cam.motion.derivatives(angle), cam.size)
        return np.array(found[:3])

    reported = traced(theta)
    for order in range(2):
        slope, _ = slopes(lambda angle, k=order: traced(angle)[k], theta, reach)
        for name, mine, found in zip("xy", reported[order + 1], slope, strict=True):
            agree(f"{name}, derivative {order + 1}", theta, mine, found, np.array(1e-8))


@family
@pytest.mark.parametrize("turns", ["ccw", "cw"])
def test_an_analysis_finds_the_extremes_of_the_profile(kind: str, sample: int, turns: str) -> None:
    question = spec(kind, sample, rotation=turns)
    found = analyse(question)
    assert found.holds, found.violated
    degrees = np.linspace(0.0, 360.0, 36_001)
    p, omega = profile(question, np.radians(degrees)), question.machine().omega
    curves = {
        f"{name}, turn": p.s[k] * omega**k / per_unit(question) for k, name in enumerate(NAMES)
    }
    starts = np.cumsum([0.0, 97.3, 41.2, 118.9, 102.6])
    for over in get_args(Over):
        at = [
            i for i, segment in enumerate(question.program) if over in ("turn", segment.kind)
        ]  # fmt: skip
        inside = [(degrees >= starts[i]) & (degrees <= starts[i + 1]) for i in at]
        alpha = np.degrees(p.pressure_angle)
        curves[f"pressure_angle, {over}"] = alpha[np.any(inside, axis=0)]
    curves["pitch_curvature, turn"], curves["profile_radius, turn"] = p.curvature, p.radius
    for reported in found.curves:
        want = curves.get(f"{reported.curve}, {reported.over}")
        if want is None or reported.curve == "jerk":  # at the ends of laws it has two values
            continue
        scale = 1e-5 * np.max(abs(want)) + 1e-9
        assert reported.largest.value == pytest.approx(np.max(want), abs=scale), reported.curve
        assert reported.smallest.value == pytest.approx(np.min(want), abs=scale), reported.curve


@family
def test_motion_is_told_in_the_unit_of_its_travel(kind: str, sample: int) -> None:
    question = spec(kind, sample, objective=[{"kind": "peak_acceleration"}, {"kind": "rms_jerk"}])
    unit, design = question.follower.travel.unit, synthesise(question)
    assert design.certificate.certified
    assert set(design.objectives) == {
        f"peak_acceleration_{unit}_per_s2", f"rms_jerk_{unit}_per_s3",
    }  # fmt: skip
    theta = np.linspace(0.0, 2.0 * np.pi, 72_001)
    s, omega = given_cam(question).motion.derivatives(theta), question.machine().omega
    largest = [np.max(abs(s[k])) * omega**k / per_unit(question) for k in range(4)]
    reported = {e.limit: e for e in design.extremes}
    for order, name in enumerate(NAMES[1:], start=1):
        assert reported[name].unit == unit + ("/s", "/s²", "/s³")[order - 1]
        assert abs(reported[name].value) == pytest.approx(largest[order], rel=1e-3)
        assert reported[name].field.startswith(f"{name}/max_{unit}_per_s")
    peak = design.objectives[f"peak_acceleration_{unit}_per_s2"]
    assert peak == pytest.approx(largest[2], rel=1e-6)
    assert reported["displacement_join"].unit == unit
    other = {"mm": "deg", "deg": "mm"}[unit]
    for segment, levels in zip(design.motion, ((0, 1), (1, 1), (1, 0), (0, 0)), strict=True):
        ends = [getattr(segment, f"s_{end}_{unit}") for end in ("start", "end")]
        assert ends == pytest.approx([level * LIFTS[kind] for level in levels], rel=1e-12)
        assert getattr(segment, f"s_start_{other}") is None
        assert getattr(segment, f"s_end_{other}") is None


@family
def test_every_format_writes_it(kind: str, sample: int) -> None:
    question = spec(kind, sample)
    unit, design = question.follower.travel.unit, synthesise(question)
    profiles = {
        name: written(exporter, design, coarse(exporter))
        for name, exporter in PROFILE_FORMATS.items()
    }
    motions = {
        name: written(exporter, design, coarse(exporter))
        for name, exporter in MOTION_FORMATS.items()
    }
    for name, content in {**profiles, **{f"motion {n}": c for n, c in motions.items()}}.items():
        assert content, name
    header, *rows = list(csv.reader(io.StringIO(motions["csv"].decode())))
    assert header == [
        "theta_deg", f"s_{unit}", f"v_{unit}_per_s", f"a_{unit}_per_s2", f"j_{unit}_per_s3",
        f"ds_{unit}_per_rad", f"d2s_{unit}_per_rad2", f"d3s_{unit}_per_rad3", "side",
        "time_s",
    ]  # fmt: skip
    table = np.array(rows, dtype=float)
    s = given_cam(question).motion.derivatives(np.radians(table[:, 0]))
    omega, inside = question.machine().omega, table[:, -2] == 0
    np.testing.assert_allclose(table[:, -1], np.radians(table[:, 0]) / omega, rtol=1e-9)
    for k in range(4):
        scale = 1e-9 * np.max(abs(table[:, 1 + k]))
        wanted = s[k] * omega**k / per_unit(question)
        np.testing.assert_allclose(table[inside, 1 + k], wanted[inside], rtol=0, atol=scale)
        if k:
            wanted = s[k] / per_unit(question)
            np.testing.assert_allclose(
                table[inside, 4 + k], wanted[inside], rtol=0, atol=scale / omega**k
            )
    units = {c["name"]: c["unit"] for c in json.loads(motions["json"])["columns"]}
    assert units[f"a_{unit}_per_s2"] == f"{unit}/s²"
    shown = f"{LIFTS[kind]}" + {"mm": " mm", "deg": "°"}[unit]
    assert f"rise {shown} in 97.3°" in motions["svg"].decode()
    assert {"mm": "mm/s²", "deg": "°/s²"}[unit] in motions["svg"].decode()
