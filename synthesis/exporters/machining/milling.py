"""A program that runs a cutter's centre round the cam in X and Y, in straight lines.

X0 Y0 is the cam's axis, X and Y are the cam's frame. The feed holds for the contact: it is given
for every block, or (inverse_time, G93) as 1 over the block's time. Without ``safe_z_mm`` nothing
moves in Z. Spindle, coolant and tool are left to the operator.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.measure import polyline_form
from synthesis.exporters.machining.lead import Lead, checked, leads
from synthesis.exporters.machining.program import (
    Feed,
    FeedMode,
    LineNumbers,
    MachineDecimals,
    check_tool,
    feed_word,
    heading,
    minutes,
    numbered,
    remark,
    tool,
    whole_path,
    word,
)
from synthesis.exporters.options import PointOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import Written, turned, written_points
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN


@dataclass(frozen=True)
class MillingOptions(PointOptions):
    """As ``PointOptions``, and how the cutter runs.

    Attributes:
        feed_mm_per_min: of the contact along the profile. feed_mode: how it is written.
        lead_mm: radius of the arcs by which the cutter comes and goes; 0: none.
        safe_z_mm: height of rapid moves, above z_mm; None: no moves in Z at all.
        z_mm: height of the cut; None: 0.
        line_numbers: whether blocks are numbered.
    """

    decimals: MachineDecimals = 4
    feed_mm_per_min: Feed = 200.0
    feed_mode: Annotated[
        FeedMode, Field(description="Feed in mm/min (G94), or as 1/min of each block (G93).")
    ] = "per_minute"
    lead_mm: Annotated[
        float,
        Field(
            ge=0.0,
            le=1e6,
            description="Come and go on quarter circles of this radius, tangent to the path; 0: "
            "on the path itself.",
        ),
    ] = 0.0
    safe_z_mm: Annotated[
        float | None,
        Field(
            ge=-1e6,
            le=1e6,
            description="Height of rapid moves, above the cut at z_mm (0 where that is left out). "
            "Left out: nothing moves in Z.",
        ),
    ] = None
    line_numbers: LineNumbers = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.safe_z_mm is not None and self.safe_z_mm <= self.depth:
            raise InputError(
                "/safe_z_mm", self.safe_z_mm,
                f"The rapid moves would run through the material: this height must lie above the "
                f"cut, which is at z_mm = {self.depth:g}.",
                "Raise safe_z_mm above the workpiece, or lower z_mm (0 where it is left out).",
            )  # fmt: skip

    @property
    def depth(self) -> float:
        """Height of the cut [mm]."""
        return 0.0 if self.z_mm is None else self.z_mm


def _profile(design: Design, options: MillingOptions) -> bytes:
    cam = chosen(design, options)
    check_tool(cam, options)
    written = written_points(cam, options)
    path = whole_path(written, options)
    arcs = _leads(cam, written, path, options) if options.lead_mm > 0.0 else []
    start = arcs[0].start if arcs else path[0]
    off = 1e3 * polyline_form(cam, written, options.turn_deg)
    blocks = [
        *heading(design, options, len(path)),
        remark(tool(cam, options)),
        remark(f"X0 Y0 IS THE CAM AXIS. CONTACT RUNS AT {options.feed_mm_per_min:.12g} MM/MIN"),
        remark(f"THE STRAIGHT LINES KEEP WITHIN {off:.3g} UM OF THE PATH"),
        "G21 G17 G90 G40 G94",
        *_down(start, options),
        *(_arc(arc, options) for arc in arcs[:1]),
        *_round(minutes(cam, written, path, options.feed_mm_per_min), path, options),
        *(_arc(arc, options) for arc in arcs[1:]),
        *([] if options.safe_z_mm is None else [f"G0 {_z(options.safe_z_mm, options)}"]),
        "M30",
    ]
    return numbered(blocks, options.line_numbers)


def _xy(point: Array, options: MillingOptions) -> str:
    x, y = (word(letter, v, options.decimals) for letter, v in zip("XY", point, strict=True))
    return f"{x} {y}"


def _z(height: float, options: MillingOptions) -> str:
    return word("Z", height, options.decimals)


def _down(start: Array, options: MillingOptions) -> list[str]:
    """To where the path begins."""
    there = f"G0 {_xy(start, options)}"
    if options.safe_z_mm is None:
        return [there]
    plunge = f"G1 {_z(options.depth, options)} {feed_word(options.feed_mm_per_min)}"
    return [f"G0 {_z(options.safe_z_mm, options)}", there, plunge]


def _round(time: Array, path: Array, options: MillingOptions) -> list[str]:
    """The path from its second point on; G1 and G93 hold on, so they stand once."""
    inverse = options.feed_mode == "inverse_time"
    feeds = 1.0 / time if inverse else np.hypot(*np.diff(path, axis=0).T) / time
    lines = [
        f"{_xy(point, options)} {feed_word(feed)}"
        for point, feed in zip(path[1:], feeds.tolist(), strict=True)
    ]
    lines[0] = f"G1 {lines[0]}"
    return ["G93", *lines, "G94"] if inverse else lines


def _arc(arc: Lead, options: MillingOptions) -> str:
    """At the feed, with I and J from its start to its centre."""
    i, j = arc.centre - arc.start
    centre = f"{word('I', i, options.decimals)} {word('J', j, options.decimals)}"
    way = "G3" if arc.ccw else "G2"
    return f"{way} {_xy(arc.end, options)} {centre} {feed_word(options.feed_mm_per_min)}"


def _leads(cam: Cam, written: Written, path: Array, options: MillingOptions) -> list[Lead]:
    """In and out, each checked."""
    count = len(written.theta)
    found: list[Lead] = []
    turn = np.stack(turned(options.turn_deg, *np.eye(2)))
    for index, step in ((0, path[1] - path[0]), (len(path) - 1, path[-1] - path[-2])):
        at = cam.at(written.theta[[index % count]] % FULL_TURN)
        outward = cam.flank.side * np.array([at.normal_x[0], at.normal_y[0]])
        away = np.array(turned(options.turn_deg, *outward))
        ahead = np.array([-away[1], away[0]])
        along = ahead if np.dot(ahead, step) > 0.0 else -ahead
        lead = leads(path[index], along, away, options.lead_mm)[len(found)]
        checked(cam, lead, path[index], options.lead_mm, turn)
        found.append(lead)
    return found


PROFILE = Exporter(
    "nc", "Program for milling, X and Y", "text/plain; charset=us-ascii", ".nc",
    _profile, MillingOptions,
    "Milling, wire erosion, lasers: path of the tool's centre (curve=cutter and its diameter), "
    "feed constant along the profile.",
    by_default=False,
)  # fmt: skip
