"""A follower on an arm, as the drawing of the cam shows it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from tests.catalogue.followers.samples import spec
from tests.exporters.test_drawings import drawn, floats, of_class, text_boxes, texts


@pytest.mark.parametrize("sample", [0, 1])
@pytest.mark.parametrize("turns", ["ccw", "cw"])
def test_the_arm_holds_roller_and_pivot(sample: int, turns: str) -> None:
    question = spec("oscillating_roller", sample, rotation=turns)
    design = synthesise(question)
    root, mirror = drawn("profile", design), -1.0 if turns == "cw" else 1.0
    arm, size = question.follower, design.dimensions
    gamma, sigma = np.radians(arm.pivot_direction_deg), {"opposite": 1.0, "same": -1.0}[arm.sense]
    pivot = arm.centre_distance_mm * np.exp(1j * gamma)
    back = gamma + np.pi - sigma * np.radians(size["initial_angle_deg"])
    roller = pivot + arm.arm_mm * np.exp(1j * back)
    circles = [floats(each, "cx", "cy", "r") for each in of_class(root, "circle")]
    for point, radii in ((roller, [arm.roller_radius_mm]), (pivot, [])):
        here = [
            r for x, y, r in circles if np.hypot(x - mirror * point.real, y - point.imag) < 1e-3
        ]
        assert len(here) == 2, "a roller with its pin, an eye with its pin"
        assert all(any(abs(r - wanted) < 1e-3 for r in here) for wanted in radii)
    lines = [floats(each, "x1", "y1", "x2", "y2") for each in of_class(root, "line", "centre")]
    want = [mirror * pivot.real, pivot.imag, mirror * roller.real, roller.imag]
    assert any(np.allclose(line, want, atol=1e-3) for line in lines)
    words = texts(root)
    assert "swing 23.3°" in words
    assert f"arm 81.3 mm, pivot at {arm.centre_distance_mm:g} mm" in words
    assert not any("offset" in each for each in words)


def test_texts_do_not_overlap() -> None:
    root = drawn("profile", synthesise(spec("oscillating_roller")))
    boxes = text_boxes(root)
    for k, (a, (left, low, right, high)) in enumerate(boxes):
        for b, (x0, y0, x1, y1) in boxes[k + 1 :]:
            apart = right <= x0 or x1 <= left or high <= y0 or y1 <= low
            assert apart, f"{a!r} overlaps {b!r}"


def test_both_rollers_of_a_lever_hang_on_arms() -> None:
    example = json.loads(Path("openapi/examples/conjugate-arms.json").read_text())["value"]
    for segment in example["program"]:
        if segment["kind"] != "dwell":
            segment["law"] = {"kind": "cycloidal"}
    example["tolerance"], example["limits"] = 0.3, []
    root = drawn("profile", synthesise(DesignSpec.model_validate(example)))
    edges = [
        each for each in of_class(root, "path", "line", "outline")
        if len(re.findall(r"-?[\d.]+", each.get("d", ""))) == 4
    ]  # fmt: skip
    assert len(edges) == 4, "two edges of each arm"
