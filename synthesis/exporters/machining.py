"""Programs for machine tools: paths of cutters and wheels with a feed (ISO 6983, "G-code").

In: a design, ``PointOptions``, a feed. Out: blocks of text in what all dialects share: millimetres
(G21), absolute (G90), no cutter compensation (G40), so the path is that of the tool's centre; G1
and coordinates as words; comments in parentheses, ASCII capitals. Spindle, coolant and tool are
left to the operator. Each block takes the time in which the contact runs along it at the feed.

milling     The centre runs round the cam in X and Y, in straight lines. X0 Y0 is the cam's axis, X
            and Y are the cam's frame. The feed is given for every block, or (inverse_time, G93) as
            1 over the block's time. Without ``safe_z_mm`` nothing moves in Z.
grinding    The cam turns by C, counter-clockwise positive, and the wheel's centre is shifted along
            X, its distance from the cam's axis, so that point after point of the path comes there
            (also polar milling). C runs on beyond 360 degrees. C and X have no common feed: every
            block bears 1 over its time (G93).
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.exporters.exporter import design_format
from synthesis.exporters.fidelity.measure import polyline_form
from synthesis.exporters.options import CurveName, PointOptions, is_cutter, is_pitch
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.cutting import checked_cam, largest_cutter, walls
from synthesis.exporters.samples.sampling import Written, rotate, written_points
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

ROUNDING = 1e-6  # relative: a roller touches both walls of its own groove
FASTEST = 10.0  # times the feed: most that a centre is moved at, round a corner say
LONGEST_NAME = 40  # letters of a design's name in a comment
CHECKED = 1440  # places of the profile from which a lead has to keep away
ALONG = np.linspace(0.05, 1.0, 20) * 0.5 * np.pi  # places of a lead [rad]
ROOM_MM = 1e-3  # what a lead may seem to cut, as both are taken at places
C_DECIMALS = 6  # of C, in degrees
PATH_DECIMALS = 12  # of the path in mm, before it is turned into pairs of C and X

MachineDecimals = Annotated[int, Field(ge=2, le=15)]


@dataclass(frozen=True)
class ProgramOptions(PointOptions):
    """As ``PointOptions``, and how fast the contact runs."""

    decimals: MachineDecimals = 4
    """Decimals of a coordinate in mm; fewer than 2 would show."""
    feed_mm_per_min: Annotated[float, Field(gt=0.0, le=1e6)] = 200.0
    """Speed at which the contact runs along the profile [mm/min], the same everywhere; a centre
    that is farther out moves faster, at most ten times."""


@dataclass(frozen=True)
class MillingOptions(ProgramOptions):
    """How the cutter runs; ``z_mm``: height of the cut, None: 0."""

    feed_mode: Literal["per_minute", "inverse_time"] = "per_minute"
    """Feed in mm/min (G94), or as 1/min of each block (G93)."""
    lead_mm: Annotated[float, Field(ge=0.0, le=1e6)] = 0.0
    """Come and go on quarter circles of this radius, tangent to the path; 0: on the path itself."""
    safe_z_mm: Annotated[float | None, Field(ge=-1e6, le=1e6)] = None
    """Height of rapid moves, above the cut at z_mm (0 where that is left out). Left out: nothing
    moves in Z."""
    line_numbers: bool = False
    """Number the blocks: N10, N20, …"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.safe_z_mm is not None and self.safe_z_mm <= self.depth:
            raise self.refusal(
                "safe_z_mm",
                f"The rapid moves would run through the material: this height must lie above the "
                f"cut, which is at z_mm = {self.depth:g}.",
                "Raise safe_z_mm above the workpiece, or lower z_mm (0 where it is left out).",
            )

    @property
    def depth(self) -> float:
        """Height of the cut [mm]."""
        return self.z_mm or 0.0


@dataclass(frozen=True)
class GrindingOptions(ProgramOptions):
    """How the wheel runs."""

    curve: CurveName = "pitch"
    """Path of the wheel's centre: cutter, outer_cutter, counter_cutter with cutter_diameter_mm, or
    pitch, counter_pitch: a wheel as large as the roller."""
    decimals: MachineDecimals = 5
    feed_mm_per_min: Annotated[float, Field(gt=0.0, le=1e6)] = 1000.0
    x_is_diameter: bool = False
    """Write X as a diameter, twice the distance from the axis."""
    line_numbers: bool = False
    """Number the blocks: N10, N20, …"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tolerance_um is not None:
            raise self.refusal(
                "tolerance_um",
                "Between pairs of C and X the wheel runs on no straight line, to which a chord "
                "tolerance could be measured.",
                "Ask for points or points_per_degree.",
            )
        if not (is_cutter(self.curve) or is_pitch(self.curve)):
            raise self.refusal(
                "curve",
                "This curve is the profile itself: a wheel whose centre ran along it would grind "
                "its own radius too deep.",
                "Give curve=cutter and cutter_diameter_mm, the wheel's diameter, or curve=pitch "
                "for a wheel as large as the roller.",
            )


@dataclass(frozen=True, eq=False)
class ToolPath:
    """The path of a tool's centre.

    Attributes:
        cam: the cam and the curve. written: its points, of which ``points`` may repeat some.
        points: (k + 1, 2) once round, back to the first point, and on as the options say [mm].
        minutes: (k,) time of each step, so that the contact runs along the profile at the feed.
        remarks: what the program is of, and its tool.
    """

    cam: Cam
    written: Written
    points: Array
    minutes: Array
    remarks: tuple[str, ...]

    @classmethod
    def of(cls, design: Design, options: ProgramOptions) -> ToolPath:
        """The path whose contact runs along the profile at the feed.

        InputError: as ``checked_cam`` and ``written_points``; the path is open; or the tool that
        the path of a roller's centre stands for does not fit.
        """
        cam, feed = checked_cam(design, options), options.feed_mm_per_min
        tool = _tool(cam, options)
        written = written_points(cam, options)
        if options.closed is False and options.overlap_points == 0:
            rule = "A tool goes round the cam to where it began."
            raise options.refusal("closed", rule, "Leave it out.")
        points = written.ended(options, closed=True)
        at = cam.at(written.theta % FULL_TURN)
        contact = np.column_stack([at.x, at.y])
        contact = np.vstack([contact, contact[: len(points) - len(contact)]])
        # The feed is the contact's; where that hardly moves, the centre's speed is bounded.
        touched, moved = (np.hypot(*np.diff(each, axis=0).T) for each in (contact, points))
        minutes = np.maximum(touched / feed, moved / (FASTEST * feed))
        remarks = (
            f"CAMWRIGHT {design.engine_version}, DESIGN {design.id}",
            f"NAME {design.name[:LONGEST_NAME]}",
            f"PATH {options.curve.replace('_', ' ')}, {len(points)} POINTS",
            tool,
        )
        return cls(cam, written, points, minutes, tuple(map(_remark, remarks)))


def _tool_radius(cam: Cam) -> float:
    """Distance of the path from the profile: the radius of the cutter or wheel [mm]."""
    return abs(cam.flank.side * cam.flank.distance - cam.gap)


def _tool(cam: Cam, options: ProgramOptions) -> str:
    """The tool in words.

    A pitch curve without a roller is refused, and one whose tool cuts off part of the profile. The
    curves of cutters are checked where the curve is chosen.
    """
    if is_cutter(options.curve):
        return f"TOOL DIAMETER {options.cutter_diameter_mm:.12g} MM"
    if not is_pitch(options.curve):
        return "THE PATH IS THE PROFILE ITSELF: COMPENSATE FOR THE TOOL"
    radius = _tool_radius(cam)
    if radius == 0.0:
        raise options.refusal(
            "curve",
            "This follower has no roller of a radius above 0. Its pitch curve is the profile "
            "itself: a tool whose centre ran along it would cut its own radius too deep.",
            "Give curve=cutter and cutter_diameter_mm, the tool's diameter.",
        )
    fit = largest_cutter(cam)
    if radius > fit.radius * (1.0 + ROUNDING):
        raise options.refusal(
            "curve",
            f"A tool as large as the roller, {2.0 * radius:.6g} mm in diameter, cuts into the "
            f"profile at cam angle {fit.angle_deg:.6g}°, x = {fit.x:.6g}, y = {fit.y:.6g} mm. No "
            f"tool larger than {2.0 * fit.radius:.6g} mm leaves it as it is.",
            "Give curve=cutter and cutter_diameter_mm, or give the design the "
            "limit profile_radius and ask for it again.",
        )
    return f"TOOL AS LARGE AS THE ROLLER, DIAMETER {2.0 * radius:.12g} MM"


def _milling(design: Design, options: MillingOptions) -> bytes:
    path, decimals = ToolPath.of(design, options), options.decimals
    points, feed = path.points, _feed_word(options.feed_mm_per_min)
    # the leads, and how far the straight lines are from the path
    come, go = ([_lead(path, options, end)] if options.lead_mm > 0.0 else [] for end in (0, -1))
    off = 1e3 * polyline_form(path.cam, path.written, options.turn_deg)

    def xy(point: Array, letters: str = "XY") -> str:
        pairs = zip(letters, point, strict=True)
        return " ".join(_word(letter, value, decimals) for letter, value in pairs)

    def arc(lead: Arc) -> str:
        """At the feed, with I and J from its start to its centre."""
        centre = xy(lead.centre - lead.start, "IJ")
        return f"{'G3' if lead.ccw else 'G2'} {xy(lead.end)} {centre} {feed}"

    down = up = []
    if options.safe_z_mm is not None:
        up = [f"G0 {_word('Z', options.safe_z_mm, decimals)}"]
        down = [f"G1 {_word('Z', options.depth, decimals)} {feed}"]
    # the path from its second point on; G1 and G93 hold on, so they stand once
    inverse = options.feed_mode == "inverse_time"
    steps = 1.0 if inverse else np.hypot(*np.diff(points, axis=0).T)
    feeds = map(_feed_word, (steps / path.minutes).tolist())
    lines = [f"{xy(point)} {f}" for point, f in zip(points[1:], feeds, strict=True)]
    lines[0] = f"G1 {lines[0]}"
    blocks = [
        *path.remarks,
        _remark(f"X0 Y0 IS THE CAM AXIS. CONTACT RUNS AT {options.feed_mm_per_min:.12g} MM/MIN"),
        _remark(f"THE STRAIGHT LINES KEEP WITHIN {off:.3g} UM OF THE PATH"),
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
    return _program(blocks, options.line_numbers)


def _grinding(design: Design, options: GrindingOptions) -> bytes:
    path = ToolPath.of(design, replace(options, decimals=PATH_DECIMALS))
    x, y = path.points.T
    turned = np.degrees(np.unwrap(-np.arctan2(y, x)))
    distance = np.hypot(x, y) * (2.0 if options.x_is_diameter else 1.0)
    pairs = [
        f"{_word('C', c, C_DECIMALS)} {_word('X', r, options.decimals)}"
        for c, r in zip(turned.tolist(), distance.tolist(), strict=True)
    ]
    feeds = map(_feed_word, (1.0 / path.minutes).tolist())
    rows = [f"{pair} {feed}" for pair, feed in zip(pairs[1:], feeds, strict=True)]
    double = "DOUBLE " if options.x_is_diameter else ""
    blocks = [
        *path.remarks,
        _remark(
            f"C TURNS THE CAM, X IS THE {double}DISTANCE OF THE WHEEL CENTRE FROM THE CAM AXIS"
        ),
        _remark(f"CONTACT RUNS AT {options.feed_mm_per_min:.12g} MM/MIN"),
        "G21 G90 G40",
        f"G0 {pairs[0]}",
        "G93",
        f"G1 {rows[0]}",
        *rows[1:],
        "G94",
        "M30",
    ]
    return _program(blocks, options.line_numbers)


class Arc(NamedTuple):
    """A quarter circle; start, centre and end are (2,) [mm]; ``ccw``: in which sense it runs."""

    start: Array
    centre: Array
    end: Array
    ccw: bool


def _lead(path: ToolPath, options: MillingOptions, index: Literal[0, -1]) -> Arc:
    """The arc that leads to the path's first point or from its last, on the side off the cam.

    InputError: on the arc the cutter would touch the cam.
    """
    cam, radius, steps = path.cam, options.lead_mm, np.diff(path.points, axis=0)
    at = cam.at(np.resize(path.written.theta, len(path.points))[[index]] % FULL_TURN)
    # the path's direction, and at right angles to it the way off the cam
    outward = cam.flank.side * np.array([at.normal_x[0], at.normal_y[0]])
    away = np.array(rotate(options.turn_deg, *outward))
    ahead = np.array([-away[1], away[0]])
    along = ahead if np.dot(ahead, steps[index]) > 0.0 else -ahead
    away = away - np.dot(away, along) * along
    away = away / np.hypot(*away)
    point, centre = path.points[index], path.points[index] + radius * away
    free = centre - radius * along if index == 0 else centre + radius * along
    # Places of the arc, turned back to the cam's frame, against places of the cam.
    cam_points = walls(cam, FULL_TURN * np.arange(CHECKED) / CHECKED)
    to_point, to_free = (end[:, None] - centre[:, None] for end in (point, free))
    arc = centre[:, None] + to_point * np.cos(ALONG) + to_free * np.sin(ALONG)
    arc = np.stack(rotate(options.turn_deg, *np.eye(2))).T @ arc
    distance = np.hypot(*(arc[:, :, None] - cam_points[:, None, :])).min()
    if distance < _tool_radius(cam) - ROOM_MM:
        raise options.refusal(
            "lead_mm",
            "On a lead of this radius the tool would cut into the cam: there is not so much room "
            f"where the path begins (it would be {_tool_radius(cam) - distance:.3g} mm inside).",
            "Take a shorter one, another start_deg, or 0 for none.",
        )
    ccw = bool(along[0] * away[1] - along[1] * away[0] > 0.0)
    return Arc(free, centre, point, ccw) if index == 0 else Arc(point, centre, free, ccw)


def _remark(text: str) -> str:
    """A comment; what could end it, or is not ASCII, is left out."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().upper()
    return f"({' '.join(re.sub(r'[^A-Z0-9 .,:;=+/_-]', ' ', plain).split())})"


def _word(letter: str, value: float, decimals: int) -> str:
    """A coordinate, always with a point: X12. means millimetres everywhere, X12 not."""
    return f"{letter}{round(value, decimals) + 0.0:.{decimals}f}"


def _feed_word(value: float) -> str:
    """A feed of five digits, without an exponent."""
    text = np.format_float_positional(value, precision=5, unique=False, fractional=False, trim="-")
    return f"F{text}"


def _program(blocks: Iterable[str], with_numbers: bool) -> bytes:
    """The program's bytes; comments bear no number."""
    lines, number = [], 0
    for block in blocks:
        if with_numbers and not block.startswith("("):
            number += 10
            block = f"N{number} {block}"
        lines.append(block)
    return ("\n".join(lines) + "\n").encode("ascii")


MILLING = design_format("profile", "nc", _milling, MillingOptions)
GRINDING = design_format("profile", "grinding.nc", _grinding, GrindingOptions)
