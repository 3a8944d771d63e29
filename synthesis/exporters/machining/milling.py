"""A program that runs a cutter's centre round the cam in X and Y, in straight lines.

X0 Y0 is the cam's axis, X and Y are the cam's frame. The feed holds for the contact: it is given
for every block, or (inverse_time, G93) as 1 over the block's time. Without ``safe_z_mm`` nothing
moves in Z. Spindle, coolant and tool are left to the operator.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.measure import polyline_form
from synthesis.exporters.machining.program import (
    Feed,
    LineNumbers,
    MachineDecimals,
    ToolPath,
    feed_word,
    remark,
    to_bytes,
    tool_radius,
    word,
)
from synthesis.exporters.options import PointOptions
from synthesis.exporters.samples.sampling import rotate
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

CHECKED = 1440  # places of the profile from which the lead has to keep away
ALONG = np.linspace(0.05, 1.0, 20) * 0.5 * np.pi  # places of a lead [rad]
ROOM = 1e-3  # what a lead may seem to cut, as both are taken at places [mm]


@dataclass(frozen=True)
class MillingOptions(PointOptions):
    """As ``PointOptions``, and how the cutter runs; ``z_mm``: height of the cut, None: 0."""

    decimals: MachineDecimals = 4
    feed_mm_per_min: Feed = 200.0
    feed_mode: Literal["per_minute", "inverse_time"] = "per_minute"
    """Feed in mm/min (G94), or as 1/min of each block (G93)."""
    lead_mm: Annotated[float, Field(ge=0.0, le=1e6)] = 0.0
    """Come and go on quarter circles of this radius, tangent to the path; 0: on the path itself."""
    safe_z_mm: Annotated[float | None, Field(ge=-1e6, le=1e6)] = None
    """Height of rapid moves, above the cut at z_mm (0 where that is left out). Left out: nothing
    moves in Z."""
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


class Arc(NamedTuple):
    """A quarter circle; start, centre and end are (2,) [mm]; ``ccw``: in which sense it runs."""

    start: Array
    centre: Array
    end: Array
    ccw: bool


def _profile(design: Design, options: MillingOptions) -> bytes:
    path = ToolPath.of(design, options, options.feed_mm_per_min)
    points, decimals = path.points, options.decimals
    come, go = _leads(path, options) if options.lead_mm > 0.0 else ([], [])
    off = 1e3 * polyline_form(path.cam, path.written, options.turn_deg)
    feed = feed_word(options.feed_mm_per_min)

    def xy(point: Array, letters: str = "XY") -> str:
        pairs = zip(letters, point, strict=True)
        return " ".join(word(letter, value, decimals) for letter, value in pairs)

    def arc(lead: Arc) -> str:
        """At the feed, with I and J from its start to its centre."""
        centre = xy(lead.centre - lead.start, "IJ")
        return f"{'G3' if lead.ccw else 'G2'} {xy(lead.end)} {centre} {feed}"

    down = up = []
    if options.safe_z_mm is not None:
        up = [f"G0 {word('Z', options.safe_z_mm, decimals)}"]
        down = [f"G1 {word('Z', options.depth, decimals)} {feed}"]
    # the path from its second point on; G1 and G93 hold on, so they stand once
    inverse = options.feed_mode == "inverse_time"
    steps = 1.0 if inverse else np.hypot(*np.diff(points, axis=0).T)
    feeds = map(feed_word, (steps / path.minutes).tolist())
    lines = [f"{xy(point)} {f}" for point, f in zip(points[1:], feeds, strict=True)]
    lines[0] = f"G1 {lines[0]}"
    blocks = [
        *path.remarks,
        remark(f"X0 Y0 IS THE CAM AXIS. CONTACT RUNS AT {options.feed_mm_per_min:.12g} MM/MIN"),
        remark(f"THE STRAIGHT LINES KEEP WITHIN {off:.3g} UM OF THE PATH"),
        "G21 G17 G90 G40 G94",
        *up,
        f"G0 {xy(come[0].start if come else points[0])}",
        *down,
        *map(arc, come),
        *(["G93", *lines, "G94"] if inverse else lines),
        *map(arc, go),
        *up,
        "M30",
    ]
    return to_bytes(blocks, options.line_numbers)


def _leads(path: ToolPath, options: MillingOptions) -> tuple[list[Arc], list[Arc]]:
    """The arcs that lead to the path and from it, tangent to it on the side off the cam."""
    cam, points, radius = path.cam, path.points, options.lead_mm
    count = len(path.written.theta)
    leads = []
    for index, step in ((0, points[1] - points[0]), (len(points) - 1, points[-1] - points[-2])):
        at = cam.at(path.written.theta[[index % count]] % FULL_TURN)
        outward = cam.flank.side * np.array([at.normal_x[0], at.normal_y[0]])
        away = np.array(rotate(options.turn_deg, *outward))
        ahead = np.array([-away[1], away[0]])
        along = ahead if np.dot(ahead, step) > 0.0 else -ahead
        away = away - np.dot(away, along) * along
        away = away / np.hypot(*away)
        point, centre = points[index], points[index] + radius * away
        ccw = bool(along[0] * away[1] - along[1] * away[0] > 0.0)
        free = centre - radius * along if index == 0 else centre + radius * along
        _check_lead(path, free - centre, centre, point - centre, options)
        leads.append(Arc(free, centre, point, ccw) if index == 0 else Arc(point, centre, free, ccw))
    return leads[:1], leads[1:]


def _check_lead(
    path: ToolPath, free: Array, centre: Array, point: Array, options: MillingOptions
) -> None:
    """Refuse a lead on which the cutter would touch the cam; its ends lie off its centre."""
    cam = path.cam
    theta = FULL_TURN * np.arange(CHECKED) / CHECKED
    walls = [each.at(theta) for each in cam.flanks() if each.flank.path == cam.flank.path]
    cam_points = np.hstack([np.stack([wall.x, wall.y]) for wall in walls])
    arc = centre[:, None] + point[:, None] * np.cos(ALONG) + free[:, None] * np.sin(ALONG)
    arc = np.stack(rotate(options.turn_deg, *np.eye(2))).T @ arc
    distance = np.hypot(*(arc[:, :, None] - cam_points[:, None, :])).min()
    if distance < tool_radius(cam) - ROOM:
        raise InputError(
            "/lead_mm", options.lead_mm,
            "On a lead of this radius the tool would cut into the cam: there is not so much room "
            f"where the path begins (it would be {tool_radius(cam) - distance:.3g} mm inside).",
            "Take a shorter one, another start_deg, or 0 for none.",
        )  # fmt: skip


PROFILE = Exporter(
    "nc", "Program for milling, X and Y", "text/plain; charset=us-ascii", ".nc",
    _profile, MillingOptions,
    "Milling, wire erosion, lasers: path of the tool's centre (curve=cutter and its diameter), "
    "feed constant along the profile.",
    by_default=False,
)  # fmt: skip
