"""A program that turns the cam (C) and shifts the wheel (X): cam grinding, polar milling.

The wheel's centre lies on the machine's X axis at the distance X from the cam's axis, and the cam
turns by C, counter-clockwise positive, so that point after point of the centre's path comes there.
C runs on beyond 360 degrees. Every block bears 1 over its time (G93), so that the contact runs
along the profile with constant speed; C and X have no common feed otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.machining.program import (
    Feed,
    LineNumbers,
    MachineDecimals,
    ToolPath,
    feed_word,
    remark,
    to_bytes,
    word,
)
from synthesis.exporters.options import CurveName, PointOptions, is_cutter, is_pitch

CDECIMALS = 6  # of C, in degrees
EXACT = 12  # of the path, before it is turned into pairs


@dataclass(frozen=True)
class GrindingOptions(PointOptions):
    """As ``PointOptions``, and how the wheel runs."""

    curve: CurveName = "pitch"
    """Path of the wheel's centre: cutter, outer_cutter, counter_cutter with cutter_diameter_mm, or
    pitch, counter_pitch: a wheel as large as the roller."""
    decimals: MachineDecimals = 5
    feed_mm_per_min: Feed = 1000.0
    x_is_diameter: bool = False
    """Write X as a diameter, twice the distance from the axis."""
    line_numbers: LineNumbers = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tolerance_um is not None:
            raise InputError(
                "/tolerance_um", self.tolerance_um,
                "Between pairs of C and X the wheel runs on no straight line, to which a chord "
                "tolerance could be measured.",
                "Ask for points or points_per_degree.",
            )  # fmt: skip
        if not (is_cutter(self.curve) or is_pitch(self.curve)):
            raise InputError(
                "/curve", self.curve,
                "This curve is the profile itself: a wheel whose centre ran along it would grind "
                "its own radius too deep.",
                "Give curve=cutter and cutter_diameter_mm, the wheel's diameter, or curve=pitch "
                "for a wheel as large as the roller.",
            )  # fmt: skip


def _profile(design: Design, options: GrindingOptions) -> bytes:
    path = ToolPath.of(design, replace(options, decimals=EXACT), options.feed_mm_per_min)
    x, y = path.points.T
    turned = np.degrees(np.unwrap(-np.arctan2(y, x)))
    distance = np.hypot(x, y) * (2.0 if options.x_is_diameter else 1.0)
    pairs = [
        f"{word('C', c, CDECIMALS)} {word('X', r, options.decimals)}"
        for c, r in zip(turned.tolist(), distance.tolist(), strict=True)
    ]
    feeds = map(feed_word, (1.0 / path.minutes).tolist())
    rows = [f"{pair} {feed}" for pair, feed in zip(pairs[1:], feeds, strict=True)]
    double = "DOUBLE " if options.x_is_diameter else ""
    blocks = [
        *path.remarks,
        remark(f"C TURNS THE CAM, X IS THE {double}DISTANCE OF THE WHEEL CENTRE FROM THE CAM AXIS"),
        remark(f"CONTACT RUNS AT {options.feed_mm_per_min:.12g} MM/MIN"),
        "G21 G90 G40",
        f"G0 {pairs[0]}",
        "G93",
        f"G1 {rows[0]}",
        *rows[1:],
        "G94",
        "M30",
    ]
    return to_bytes(blocks, options.line_numbers)


PROFILE = Exporter(
    "grinding.nc", "Program for grinding, C and X", "text/plain; charset=us-ascii", ".grinding.nc",
    _profile, GrindingOptions,
    "Cam grinding: pairs of the cam's angle and the wheel's distance, feed constant along the "
    "profile.",
    by_default=False,
)  # fmt: skip
