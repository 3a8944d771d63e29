"""Blocks of a program in what all dialects of ISO 6983 share.

Millimetres (G21), absolute (G90), no cutter compensation (G40): the path is that of the centre. G1
and coordinates as words; comments in parentheses, ASCII capitals.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.options import CurveOptions, PointOptions, is_cutter, is_pitch
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.cutting import checked_cam, largest_cutter
from synthesis.exporters.samples.sampling import Written, written_points
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

ROUNDING = 1e-6  # relative: a roller touches both walls of its own groove
FASTEST = 10.0  # times the feed: most that a centre is moved at, round a corner say
LONGEST_NAME = 40

MachineDecimals = Annotated[
    int,
    Field(ge=2, le=15, description="Decimals of a coordinate in mm; fewer than 2 would show."),
]
Feed = Annotated[
    float,
    Field(
        gt=0.0,
        le=1e6,
        description="Speed at which the contact runs along the profile [mm/min], the same "
        "everywhere; a centre that is farther out moves faster, at most ten times.",
    ),
]
LineNumbers = Annotated[bool, Field(description="Number the blocks: N10, N20, …")]


def remark(text: str) -> str:
    """A comment; what could end it, or is not ASCII, is left out."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().upper()
    return f"({' '.join(re.sub(r'[^A-Z0-9 .,:;=+/_-]', ' ', plain).split())})"


def to_bytes(blocks: Iterable[str], with_numbers: bool) -> bytes:
    """The program's bytes; comments bear no number."""
    lines, number = [], 0
    for block in blocks:
        if with_numbers and not block.startswith("("):
            number += 10
            block = f"N{number} {block}"
        lines.append(block)
    return ("\n".join(lines) + "\n").encode("ascii")


def word(letter: str, value: float, decimals: int) -> str:
    """A coordinate, always with a point: X12. means millimetres everywhere, X12 not."""
    text = f"{round(value, decimals) + 0.0:.{decimals}f}"
    return letter + (text if decimals else text + ".")


def feed_word(value: float) -> str:
    """A feed of five digits, without an exponent."""
    text = np.format_float_positional(value, precision=5, unique=False, fractional=False, trim="-")
    return f"F{text}"


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
    def of(cls, design: Design, options: PointOptions, feed: float) -> ToolPath:
        """The path whose contact runs along the profile at the feed [mm/min].

        Raises:
            InputError: as ``chosen`` and ``written_points``; the path is open; or the tool that
                the path of a roller's centre stands for does not fit.
        """
        cam = checked_cam(design, options)
        _check_roller_as_tool(cam, options)
        written = written_points(cam, options)
        if options.closed is False and options.overlap_points == 0:
            raise InputError(
                "/closed", False, "A tool goes round the cam to where it began.", "Leave it out."
            )
        points = written.ended(options, closed=True)
        at = cam.at(written.theta % FULL_TURN)
        contact = np.column_stack([at.x, at.y])
        contact = np.vstack([contact, contact[: len(points) - len(contact)]])
        touched = np.hypot(*np.diff(contact, axis=0).T)
        moved = np.hypot(*np.diff(points, axis=0).T)
        minutes = np.maximum(touched / feed, moved / (FASTEST * feed))
        remarks = (
            remark(f"CAMWRIGHT {design.engine_version}, DESIGN {design.id}"),
            remark(f"NAME {design.name[:LONGEST_NAME]}"),
            remark(f"PATH {options.curve.replace('_', ' ')}, {len(points)} POINTS"),
            remark(_tool(cam, options)),
        )
        return cls(cam, written, points, minutes, remarks)


def tool_radius(cam: Cam) -> float:
    """Distance of the path from the profile: the radius of the cutter or wheel [mm]."""
    return abs(cam.flank.side * cam.flank.distance - cam.gap)


def _check_roller_as_tool(cam: Cam, options: CurveOptions) -> None:
    """Refuse a pitch curve without a roller, or one whose tool cuts off a part of the profile.

    The curves of cutters are checked where the curve is chosen. A path that is the profile itself
    names no tool and is not checked.
    """
    if not is_pitch(options.curve):
        return
    radius = tool_radius(cam)
    if radius == 0.0:
        raise InputError(
            "/curve", options.curve,
            "This follower has no roller of a radius above 0. Its pitch curve is the profile "
            "itself: a tool whose centre ran along it would cut its own radius too deep.",
            "Give curve=cutter and cutter_diameter_mm, the tool's diameter.",
        )  # fmt: skip
    fit = largest_cutter(cam)
    if radius > fit.radius * (1.0 + ROUNDING):
        raise InputError(
            "/curve", options.curve,
            f"A tool as large as the roller, {2.0 * radius:.6g} mm in diameter, cuts into the "
            f"profile at cam angle {fit.angle_deg:.6g}°, x = {fit.x:.6g}, y = {fit.y:.6g} mm. No "
            f"tool larger than {2.0 * fit.radius:.6g} mm leaves it as it is.",
            "Give curve=cutter and cutter_diameter_mm, or give the design the "
            "limit profile_radius and ask for it again.",
        )  # fmt: skip


def _tool(cam: Cam, options: CurveOptions) -> str:
    if is_pitch(options.curve):
        return f"TOOL AS LARGE AS THE ROLLER, DIAMETER {2.0 * tool_radius(cam):.12g} MM"
    if is_cutter(options.curve):
        return f"TOOL DIAMETER {options.cutter_diameter_mm:.12g} MM"
    return "THE PATH IS THE PROFILE ITSELF: COMPENSATE FOR THE TOOL"
