"""Where a law's acceleration jumps every family tells both values, and none in between.

The parabolic law is ±4h/β² and jumps at its ends and in the middle, the harmonic one is
±π²h/2β² at its ends (Norton, Cam Design and Manufacturing Handbook, ch. 2).
"""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from synthesis import DesignSpec, analyse, synthesise
from synthesis.catalogue.profile import cam_profile
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS, MotionOptions, ProfileOptions
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import CASES, LIFTS, spec

pytestmark = pytest.mark.usefixtures("unmended")
family = pytest.mark.parametrize(("kind", "sample"), CASES)
UP, DOWN = 4.0 / np.radians(97.3) ** 2, 0.5 * np.pi**2 / np.radians(118.9) ** 2
# cam angle: s'' over the lift before and after
JUMPS = {
    0.0: (0.0, UP), 48.65: (UP, -UP), 97.3: (-UP, 0.0),
    138.5: (0.0, -DOWN), 257.4: (DOWN, 0.0),
}  # fmt: skip


def jumping(kind: str, sample: int) -> DesignSpec:
    return spec(kind, sample, laws=("parabolic", "simple_harmonic"), limits=[])


def accelerations(question: DesignSpec) -> dict[float, tuple[float, float]]:
    """The same in the wire's unit."""
    unit = LIFTS[question.follower.kind] * question.machine().omega ** 2
    return {at: (before * unit, after * unit) for at, (before, after) in JUMPS.items()}


@family
def test_an_analysis_tells_both_sides(kind: str, sample: int) -> None:
    question = jumping(kind, sample)
    found = analyse(question)
    reported = {j.angle_deg: (j.before, j.after) for j in found.jumps if j.curve == "acceleration"}
    wanted = accelerations(question)
    assert sorted(reported) == pytest.approx(sorted(wanted), abs=1e-9)
    for (_, mine), (_, value) in zip(sorted(reported.items()), sorted(wanted.items()), strict=True):
        assert mine == pytest.approx(value, rel=1e-12, abs=1e-9)
    (summary,) = [c for c in found.curves if (c.curve, c.over) == ("acceleration", "turn")]
    most = max(max(pair) for pair in wanted.values())
    assert summary.largest is not None
    assert summary.largest.value == pytest.approx(most, rel=1e-9)
    assert summary.largest.side in ("left", "right", "both")


@family
def test_the_curvature_jumps_to_what_the_profile_is_just_beside(kind: str, sample: int) -> None:
    question = jumping(kind, sample)
    cam, found = given_cam(question), analyse(question)
    name = "profile_radius" if "face" in kind else "pitch_curvature"
    jumps = [j for j in found.jumps if j.curve.startswith(name)]
    flank = question.follower.flanks[0]
    assert {round(j.angle_deg, 9) for j in jumps} == set(JUMPS)
    for angle in JUMPS:
        theta = np.radians((np.array([angle - 1e-7, angle + 1e-7])) % 360.0)
        p = cam_profile(cam.motion, question.follower, cam.size, "ccw", theta, flank=flank)
        beside = p.radius if "face" in kind else p.curvature
        pairs = [(j.before, j.after) for j in jumps if j.angle_deg == pytest.approx(angle)]
        assert any(np.allclose(np.abs(pair), np.abs(beside), rtol=1e-6) for pair in pairs), (
            f"{angle}°: told {pairs}, beside {beside}"
        )


@family
def test_tables_have_a_row_for_either_side(kind: str, sample: int) -> None:
    question = jumping(kind, sample)
    design, unit = synthesise(question), question.follower.travel.unit
    motion = MOTION_FORMATS["csv"].write(design, MotionOptions())
    profile = PROFILE_FORMATS["csv"].write(design, ProfileOptions())
    for content in (motion, profile):
        rows = list(csv.DictReader(io.StringIO(content.decode())))
        reported = {
            (round(float(row["theta_deg"]), 9) % 360.0, row["side"]): float(row[f"a_{unit}_per_s2"])
            for row in rows
            if row["side"] != "0"
        }
        for angle, (before, after) in accelerations(question).items():
            assert reported[angle, "-1"] == pytest.approx(before, rel=1e-9, abs=1e-9)
            assert reported[angle, "1"] == pytest.approx(after, rel=1e-9, abs=1e-9)
        largest = max(abs(float(row[f"a_{unit}_per_s2"])) for row in rows)
        assert largest == pytest.approx(max(map(max, accelerations(question).values())), rel=1e-9)
