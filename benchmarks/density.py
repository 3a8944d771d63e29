"""Points per degree: what a file's points tell of form, curvature and acceleration.

The reader of the file has nothing but its points x, y, and lays chords or a cubic spline through
them. The truth is the textbook's cam in forty digits, at angles between the points.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from functools import cached_property
from math import pi, radians

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.axis import Axis, plain, relative
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design
from synthesis.exporters import PROFILE_FORMATS, ProfileOptions
from synthesis.numerics.piecewise import Array
from tests.validation.textbook import OffsetRoller

DENSITIES = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
LIFT, RISE, DWELL, PRIME, ROLLER, OFFSET = 30.0, 60.0, 30.0, 60.0, 10.0, 20.0
PEAK = 2.0 * pi * LIFT / radians(RISE) ** 2  # of the cycloidal law's s'' [mm]
CHECKS = 240  # cam angles at which truth is computed
GOLDEN = 0.6180339887498949  # steps of it hit no grid
ROUNDED = 3  # decimals of a file in whole micrometres
LEAST = 1e-14
TEXT = """The cam of example 13-6, cycloidal laws, written as a file and read back: how near is what
a reader of the points makes of them? *Form* is the distance of the true profile from chords between
neighbouring points, or from a cubic spline through all of them; *curvature* is that of the spline
over the largest of the cam, *acceleration* what a roller would do on it, over the motion's peak.
All are the largest at {checks} cam angles between the points, against the textbook's formulas in
forty digits. The last two columns read the same points rounded to whole micrometres: more points
then make curvature and acceleration worse, because a second derivative divides the rounding by the
square of the step."""


@dataclass(frozen=True)
class Truth:
    """The cam at angles between the points: angles [deg], places (n, 2), all else (n,)."""

    degrees: Array
    places: Array
    curvature: Array
    slope: Array
    height: Array

    def acceleration(self, curvature: Array) -> Array:
        """s'' of a roller that meets a profile of this curvature there [mm].

        From κ = (X² + u (2s' − e) − X s'') / (X² + u²)^{3/2} of the pitch curve, u = s' − e.
        """
        X, u = self.height, self.slope - OFFSET
        pitch = curvature / (1.0 + ROLLER * curvature)
        return (X**2 + u * (2.0 * self.slope - OFFSET) - pitch * (X**2 + u**2) ** 1.5) / X


@dataclass(frozen=True)
class Reading:
    """A closed curve through points, in the order of falling polar angle, as the file has them."""

    degrees: Array
    places: Array

    @cached_property
    def spline(self) -> CubicSpline:
        """Over the length of the chords."""
        ring = np.vstack([self.places, self.places[:1]])
        lengths = np.hypot(*np.diff(ring, axis=0).T)
        return CubicSpline(np.append(0.0, np.cumsum(lengths)), ring, bc_type="periodic")

    def nearest(self, truth: Truth) -> Array:
        """Parameters of the spline's points beside the true ones."""
        knots = self.spline.x
        t = np.interp(truth.degrees, np.append(self.degrees, 360.0), knots)
        for _ in range(8):
            away = self.spline(t) - truth.places
            first, second = self.spline(t, 1), self.spline(t, 2)
            slope = np.sum(away * first, axis=1)
            t = t - slope / np.sum(first**2 + away * second, axis=1)
        return t

    def chords(self, truth: Truth) -> float:
        """Largest distance of true points from the chords [mm]."""
        at = np.searchsorted(self.degrees, truth.degrees) - 1
        start, end = self.places[at], self.places[(at + 1) % len(self.places)]
        along = (end - start) / np.hypot(*(end - start).T)[:, None]
        away = truth.places - start
        return float(np.max(np.abs(along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0])))

    def errors(self, truth: Truth) -> tuple[float, float, float]:
        """Form [mm], curvature and acceleration (relative) of the spline."""
        t = self.nearest(truth)
        (x1, y1), (x2, y2) = self.spline(t, 1).T, self.spline(t, 2).T
        curvature = (y1 * x2 - x1 * y2) / np.hypot(x1, y1) ** 3
        form = np.max(np.hypot(*(self.spline(t) - truth.places).T))
        bent = np.max(np.abs(curvature - truth.curvature)) / np.max(np.abs(truth.curvature))
        moved = truth.acceleration(curvature) - truth.acceleration(truth.curvature)
        return float(form), float(bent), float(np.max(np.abs(moved))) / PEAK


@dataclass(frozen=True)
class Outcome:
    """What one density is worth."""

    density: float
    points: int
    time: Timing
    chords: float
    exact: tuple[float, float, float]
    rounded: tuple[float, float, float]


def run(effort: Effort = FULL) -> Section:
    """Every density."""
    made, truth = cam(), textbook(8 if effort.trial else CHECKS)
    densities = effort.some(DENSITIES)
    calls: dict[str, Call] = {
        str(density): (lambda d=density: written(made, d)) for density in densities
    }
    times = in_turns(calls, effort.repeats(20), effort.warm_up(1))
    found = []
    for density in densities:
        points = read(written(made, density))
        coarse = Reading(points.degrees, np.round(points.places, ROUNDED))
        found.append(
            Outcome(
                density, len(points.places), times[str(density)], points.chords(truth),
                points.errors(truth), coarse.errors(truth),
            )
        )  # fmt: skip
    return Section(
        "Points per degree", TEXT.format(checks=CHECKS), [_diagram(found), _table(found)]
    )


def cam() -> Design:
    """Example 13-6 as it is given."""
    law = {"kind": "cycloidal"}
    return synthesise(
        DesignSpec.model_validate(
            {
                "speed_rpm": 300.0 / pi,
                "program": [
                    {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": law},
                    {"kind": "dwell", "angle_deg": DWELL},
                    {"kind": "return", "angle_deg": RISE, "lift_mm": LIFT, "law": law},
                    {"kind": "dwell", "angle_deg": 360.0 - 2.0 * RISE - DWELL},
                ],
                "follower": {
                    "kind": "translating_roller",
                    "roller_radius_mm": ROLLER,
                    "offset_mm": OFFSET,
                },
                "base_radius_mm": PRIME - ROLLER,
                "limits": [],
            }
        )
    )


def textbook(checks: int) -> Truth:
    """The truth in forty digits, at cam angles that are nothing special."""
    sizes = (LIFT, RISE, DWELL, PRIME, OFFSET, ROLLER, 10.0)
    book = OffsetRoller(*(str(size) for size in sizes))
    degrees = np.sort((np.arange(1, checks + 1) * GOLDEN % 1.0) * 360.0)
    rows = [book.at(book.h * 0 + type(book.h)(angle)) for angle in degrees.tolist()]
    column = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    pitch = column["curvature"]
    return Truth(
        degrees,
        np.column_stack([column["profile x"], column["profile y"]]),
        pitch / (1.0 - ROLLER * pitch),
        column["v"] / 10.0,
        np.sqrt(PRIME**2 - OFFSET**2) + column["s"],
    )


def written(made: Design, density: float) -> bytes:
    """The file."""
    return PROFILE_FORMATS["csv"].write(made, ProfileOptions(points_per_degree=density))


def read(file: bytes) -> Reading:
    """Its points, each once; cam angles tell where between them a true point lies."""
    rows = list(csv.DictReader(io.StringIO(file.decode())))
    degrees = np.array([float(row["theta_deg"]) for row in rows])
    places = np.array([[float(row["x_mm"]), float(row["y_mm"])] for row in rows])
    once = np.append(np.diff(degrees) > 0.0, False)  # jumps have two rows, the turn two ends
    return Reading(degrees[once], places[once])


def _table(found: list[Outcome]) -> Table:
    head = (
        ">points per degree", ">points", ">time of the file", ">form, chords", ">form, spline",
        ">curvature", ">acceleration", ">curvature, in µm", ">acceleration, in µm",
    )  # fmt: skip
    return Table(head, [_row(one) for one in found])


def _row(one: Outcome) -> tuple[str, ...]:
    form, curvature, acceleration = one.exact
    return (
        f"{one.density:g}", str(one.points), str(one.time),
        f"{1e3 * one.chords:.2g} µm", f"{1e3 * form:.2g} µm",
        f"{curvature:.1e}", f"{acceleration:.1e}",
        f"{one.rounded[1]:.1e}", f"{one.rounded[2]:.1e}",
    )  # fmt: skip


def _diagram(found: list[Outcome]) -> Diagram:
    curves = {
        "form by chords, over the lift": [one.chords / LIFT for one in found],
        "form by a spline, over the lift": [one.exact[0] / LIFT for one in found],
        "curvature": [one.exact[1] for one in found],
        "acceleration": [one.exact[2] for one in found],
        "curvature, points in whole µm": [one.rounded[1] for one in found],
        "acceleration, points in whole µm": [one.rounded[2] for one in found],
    }
    series = [
        Series(name, [Point(one.density, y) for one, y in zip(found, values, strict=True)])
        for name, values in curves.items()
    ]
    return Diagram(
        "density",
        "Points per degree: error of what is read back",
        "Errors fall with the density, but not where the points are rounded to micrometres.",
        Axis("points per degree", plain),
        Axis("error", relative, least=LEAST),
        series,
    )
