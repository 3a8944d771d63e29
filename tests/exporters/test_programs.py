"""Programs for machine tools, run by a small interpreter that knows ISO 6983 only."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synthesis import synthesise
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS
from synthesis.spec.design_spec import DesignSpec
from tests.exporters.test_flanks import CLOSURES, question
from tests.exporters.test_points import away, points

EXAMPLES = Path(__file__).resolve().parents[2] / "openapi" / "examples"
WORD = re.compile(r"([A-Z])(-?\d+\.?\d*)")


@dataclass
class Machine:
    """Where the axes are, what holds on, and every move with its time in minutes."""

    at: dict[str, float] = field(default_factory=dict)
    codes: set[str] = field(default_factory=set)
    motion: str = ""
    inverse: bool = False
    feed: float = 0.0
    moves: list[tuple[str, dict[str, float], dict[str, float], float]] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)

    def run(self, text: str) -> Machine:
        for line in text.splitlines():
            if line.startswith("("):
                assert re.fullmatch(r"\([^()]*\)", line)
                self.comments.append(line)
                continue
            words = WORD.findall(line)
            assert "".join(a + b for a, b in words) == line.replace(" ", ""), line
            self.block([(letter, float(value)) for letter, value in words])
        assert "M30" in self.codes
        return self

    def block(self, words: list[tuple[str, float]]) -> None:
        target, centre, feed = dict(self.at), {}, None
        for letter, value in words:
            if letter in "GM":
                self.codes.add(f"{letter}{value:g}")
                if letter == "G" and value in (0, 1, 2, 3):
                    self.motion = f"G{value:g}"
                if letter == "G" and value in (93, 94):
                    self.inverse = value == 93
            elif letter in "IJ":
                centre[letter] = value
            elif letter == "F":
                feed = value
            elif letter == "N":
                self.numbers.append(int(value))
            else:
                target[letter] = value
        if feed is not None:
            self.feed = feed
        if target == self.at:
            return
        assert feed is not None or not self.inverse or self.motion == "G0"
        self.moves.append((self.motion, dict(self.at), target, self.time(target, centre)))
        if centre:
            self.moves[-1][1].update(centre)
        self.at = target

    def time(self, target: dict[str, float], centre: dict[str, float]) -> float:
        if self.motion == "G0":
            return 0.0
        if self.inverse:
            return 1.0 / self.feed
        step = [target[each] - self.at[each] for each in target]
        return math.hypot(*step) / self.feed

    def path(self, axes: str) -> np.ndarray:
        """From the first feed move in these axes on: (k + 1, 2)."""
        cut = [move for move in self.moves if move[0] == "G1" and axes[0] in move[2]]
        cut = [m for m in cut if any(m[1][each] != m[2][each] for each in axes)]
        return np.array([[cut[0][1][each] for each in axes]] + [[m[2][each] for each in axes]
                                                                for m in cut])  # fmt: skip

    def times(self, axes: str) -> np.ndarray:
        cut = [move for move in self.moves if move[0] == "G1" and axes[0] in move[2]]
        return np.array([m[3] for m in cut if any(m[1][e] != m[2][e] for e in axes)])


def run(name: str, design: Design, **options: Any) -> Machine:
    exporter = PROFILE_FORMATS[name]
    return Machine().run(exporter.write(design, exporter.options(**options)).decode("ascii"))


@pytest.fixture(scope="module")
def groove() -> Design:
    return synthesise(question(CLOSURES["groove"], "ccw"))


@pytest.mark.parametrize("mode", ["per_minute", "inverse_time"])
def test_the_swept_cutter_leaves_the_profile(mode: str, unspecial: Design, truth) -> None:
    """Nowhere nearer than its radius, and everywhere as near; the contact's speed is the feed."""
    asked_for = {"curve": "cutter", "cutter_diameter_mm": 11.4, "points": 1500}
    machine = run("nc", unspecial, feed_mm_per_min=130.0, feed_mode=mode, **asked_for)
    assert {"G21", "G90", "G40", "G17", "M30"} <= machine.codes
    assert ("G93" in machine.codes) == (mode == "inverse_time")
    path = machine.path("XY")
    np.testing.assert_array_equal(path[0], path[-1])
    true = truth(unspecial).points(np.linspace(0.0, 360.0, 1801)[:-1])
    np.testing.assert_allclose(away(true, path[:-1]), 5.7, rtol=0.0, atol=2e-3)
    at_contact = points(unspecial, points=1500, closed=True)
    speed = np.hypot(*np.diff(at_contact, axis=0).T) / machine.times("XY")
    np.testing.assert_allclose(speed, 130.0, rtol=2e-3)
    total = np.hypot(*np.diff(true, axis=0, append=true[:1]).T).sum() / 130.0
    assert machine.times("XY").sum() == pytest.approx(total, rel=1e-4)


def test_a_chord_tolerance_holds_in_the_program(unspecial: Design, truth) -> None:
    machine = run("nc", unspecial, tolerance_um=8.0)
    path = machine.path("XY")
    true = truth(unspecial).points(np.linspace(0.0, 360.0, 5001)[:-1])
    worst = away(true, path[:-1]).max()
    assert 0.5 * 8e-3 < worst < 8e-3
    assert len(path) < 250
    (reported,) = (c for c in machine.comments if "STRAIGHT" in c)
    assert float(reported.split()[5]) == pytest.approx(1e3 * worst, rel=0.03)


def test_leads_are_tangent_and_outside(unspecial: Design) -> None:
    options = {"curve": "cutter", "cutter_diameter_mm": 9.0, "points": 400, "turn_deg": 31.0}
    more = {"safe_z_mm": 6.5, "z_mm": -12.25, "line_numbers": True, "overlap_points": 7}
    machine = run("nc", unspecial, lead_mm=4.2, **options, **more)
    bare = run("nc", unspecial, overlap_points=7, **options).path("XY")
    np.testing.assert_array_equal(machine.path("XY"), bare)
    arcs = [move for move in machine.moves if move[0] in ("G2", "G3")]
    assert len(arcs) == 2
    cam = points(unspecial, points=2000, turn_deg=31.0)
    for k, (way, start, end, _) in enumerate(arcs):
        a, b = (np.array([place["X"], place["Y"]]) for place in (start, end))
        centre = a + np.array([start["I"], start["J"]])
        for place in (a, b):
            assert np.hypot(*(place - centre)) == pytest.approx(4.2, abs=3e-4)
        (ax, ay), (bx, by) = a - centre, b - centre
        sweep = (ax * by - ay * bx) / 4.2**2
        assert sweep == pytest.approx(1.0 if way == "G3" else -1.0, abs=1e-3)
        point, along = (b, bare[1] - bare[0]) if k == 0 else (a, bare[-1] - bare[-2])
        along = along / np.hypot(*along)
        assert abs(np.dot(point - centre, along)) < 0.1  # tangent, but for half a chord's turn
        entry = np.array([-(point - centre)[1], (point - centre)[0]]) * (1 if way == "G3" else -1)
        assert np.dot(entry, along) > 4.1
        angle = np.linspace(0.0, 0.5 * math.pi, 9)[:, None]
        arc = centre + np.cos(angle) * (a - centre) + np.sin(angle) * (b - centre)
        assert away(arc, cam).min() > 4.499
    heights = [(move[0], move[2].get("Z")) for move in machine.moves]
    assert heights[0] == ("G0", 6.5)
    assert ("G1", -12.25) in heights
    assert heights[-1] == ("G0", 6.5)
    assert machine.numbers == list(range(10, 10 * len(machine.numbers) + 1, 10))


def test_a_lead_into_the_other_wall_is_refused(groove: Design) -> None:
    options = {"curve": "cutter", "cutter_diameter_mm": 13.5, "points": 300}
    run("nc", groove, lead_mm=0.4, **options)
    with pytest.raises(InputError, match="cut into the cam") as caught:
        run("nc", groove, lead_mm=6.0, **options)
    assert caught.value.field == "/lead_mm"


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_pairs_of_c_and_x_grind_the_profile(rotation: str, build, truth) -> None:
    design = build(rotation=rotation, limits=[], offset=11.3)
    options = {"curve": "cutter", "cutter_diameter_mm": 47.0, "points": 1440}
    machine = run("grinding.nc", design, feed_mm_per_min=700.0, overlap_points=30, **options)
    c, x = machine.path("CX").T
    assert np.all(np.abs(np.diff(c)) < 2.0)
    turned = np.radians(c)
    wheel = np.column_stack([x * np.cos(turned), -x * np.sin(turned)])  # as the cam sees it
    assert abs(c[-31] - c[0]) == pytest.approx(360.0, abs=1e-5)
    np.testing.assert_allclose(wheel[-31:], wheel[:31], atol=3e-5)
    true = truth(design).points(np.linspace(0.0, 360.0, 1441)[:-1])
    np.testing.assert_allclose(away(true, wheel[:-31]), 23.5, rtol=0.0, atol=3e-3)
    at_contact = points(design, points=1440, closed=True)
    speed = np.hypot(*np.diff(at_contact, axis=0).T) / machine.times("CX")[:-30]
    np.testing.assert_allclose(speed, 700.0, rtol=2e-3)
    double = run("grinding.nc", design, x_is_diameter=True, **options).path("CX")
    np.testing.assert_allclose(double[:, 1], 2.0 * x[: len(double)], atol=2e-5)


def test_what_makes_no_sense_is_refused(unspecial: Design) -> None:
    with pytest.raises(InputError, match="goes round the cam"):
        run("nc", unspecial, closed=False)
    with pytest.raises(InputError, match="straight line"):
        run("grinding.nc", unspecial, tolerance_um=1.0)
    with pytest.raises(InputError, match="at most 1e"):
        run("nc", unspecial, feed_mm_per_min=0.0)


@pytest.fixture(scope="module")
def flat_face() -> Design:
    example = json.loads((EXAMPLES / "flat-face.json").read_text())
    return synthesise(DesignSpec.model_validate(example["value"]))


def test_a_wheel_needs_a_size(flat_face: Design, build) -> None:
    """A follower without a roller has a pitch curve too: the profile itself."""
    knife_edge = build(roller=0.0, limits=[])
    for design in (flat_face, knife_edge):
        for name in ("grinding.nc", "nc"):
            with pytest.raises(InputError, match="radius too deep") as caught:
                run(name, design, curve="pitch")
            assert caught.value.field == "/curve"
            assert "cutter_diameter_mm" in caught.value.remedy
            run(name, design, curve="cutter", cutter_diameter_mm=10.0, points=90)
    with pytest.raises(InputError, match="radius too deep"):
        run("grinding.nc", flat_face)
    with pytest.raises(InputError, match="radius too deep"):
        run("grinding.nc", flat_face, curve="profile")
    run("nc", flat_face, points=90)  # the profile, for a tool that the control compensates


def test_a_tool_as_large_as_the_roller_has_to_fit(build) -> None:
    """A given cam that is undercut may be looked at, but not made with the roller as the tool."""
    undercut = build(prime=30.0, roller=28.0, offset=0.0, limits=[])
    for name in ("grinding.nc", "nc"):
        with pytest.raises(InputError, match="cuts into the profile at cam angle") as caught:
            run(name, undercut, curve="pitch")
        assert caught.value.field == "/curve"


@pytest.mark.parametrize("name", [*CLOSURES, "tight groove"])
def test_a_roller_fits_the_cams_that_it_runs_on(name: str) -> None:
    closure = CLOSURES.get(name, {"kind": "groove", "clearance_mm": 0.0})
    design = synthesise(question(closure, "ccw"))
    for curve in ("pitch", "counter_pitch") if name == "pair" else ("pitch",):
        run("grinding.nc", design, curve=curve, points=90)


@pytest.mark.parametrize(("safe", "cut"), [(-12.0, -4.0), (-4.0, -4.0), (0.0, None), (-1.0, None)])
def test_rapid_moves_run_above_the_cut(unspecial: Design, safe: float, cut: float | None) -> None:
    with pytest.raises(InputError, match="rapid moves would run through") as caught:
        run("nc", unspecial, safe_z_mm=safe, z_mm=cut)
    assert caught.value.field == "/safe_z_mm"
    assert "Raise safe_z_mm" in caught.value.remedy
    run("nc", unspecial, safe_z_mm=0.5, z_mm=cut, points=90)


@pytest.mark.parametrize("decimals", [0, 1])
def test_coordinates_are_not_rounded_to_steps_that_show(unspecial: Design, decimals: int) -> None:
    for name in ("nc", "grinding.nc"):
        with pytest.raises(InputError, match="at least 2"):
            run(name, unspecial, decimals=decimals)


def test_a_name_cannot_end_its_comment(build) -> None:
    design = build(name="Nocken (1) G0 X0)\nM30 ä %", limits=[])
    machine = run("nc", design, points=90)
    assert any("NOCKEN 1 G0 X0 M30 A" in comment for comment in machine.comments)
    assert len(machine.comments) == 6
