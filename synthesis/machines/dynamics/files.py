"""Files of a follower train's response: tables, diagrams, residual spectrum.

In: a TrainResponse and the options of a format. Out: bytes. ``TRAIN_FILES`` lists the formats.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synthesis.catalogue.fields import Speed
from synthesis.catalogue.limits.motion import runs_between_dwells
from synthesis.exporters.diagrams.plot import Frame, curve_plot, linear
from synthesis.exporters.diagrams.sheet import sheet
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import BOLD
from synthesis.exporters.exporter import FileFormat
from synthesis.exporters.options import Options, Theme
from synthesis.exporters.samples.columns import Column, concatenate
from synthesis.exporters.tables import csv_table
from synthesis.machines.dynamics import response
from synthesis.machines.dynamics.polydyne import polydyne
from synthesis.machines.dynamics.report import TrainResponse
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

MAX_TURNS, MAX_POINTS_PER_DEGREE = 20, 20.0  # so that a file takes seconds
PER_DEGREE = 2.0  # rows or points of a diagram, where nothing else is said
WIDTH, LEFT, RIGHT, TOP, TALL, BELOW = 190.0, 24.0, 8.0, 24.0, 74.0, 34.0  # mm, of the spectrum
POINTS, REACH, DECADES = 900, 8.0, 4  # REACH: swings during the longest run that are drawn
DASHES = ("line curve", "line phase", "line prime", "line circle")


@dataclass(frozen=True)
class SpeedOptions(Options):
    """Which speed is written; None: the one that the cam was designed for."""

    speed_rpm: Speed | None = None
    """Any speed; left out, that of the cam's own spec."""

    def of(self, answer: TrainResponse) -> float:
        """The speed [rpm]."""
        return self.speed_rpm or answer.spec.cam.speed_rpm


@dataclass(frozen=True)
class TrainPictureOptions(SpeedOptions):
    """How a response is drawn."""

    theme: Annotated[Theme, Field(description="Colours of the picture.")] = "auto"


@dataclass(frozen=True)
class RowOptions(SpeedOptions):
    """How close the rows of a table are."""

    points_per_degree: Annotated[float, Field(gt=0.0, le=MAX_POINTS_PER_DEGREE)] = PER_DEGREE
    """At least so many rows per degree."""


@dataclass(frozen=True)
class ResponseOptions(RowOptions):
    """What of a response is written as a table."""

    turns: Annotated[int, Field(ge=0, le=MAX_TURNS)] = 0
    """Turns from rest; 0: the periodic response."""


def _steps(answer: TrainResponse, per_degree: float) -> response.Steps:
    return response.Steps.of(answer.cam.curve, int(np.ceil(360.0 * per_degree)))


def _response_csv(answer: TrainResponse, options: ResponseOptions) -> bytes:
    """Cam, masses and contact force; a cam angle with an impact has two rows."""
    chain, omega = answer.spec.train.chain(), rad_per_s(options.of(answer))
    steps = _steps(answer, options.points_per_degree)
    turns = response.from_rest(chain, steps, omega, options.turns)
    turns = turns or [response.steady(chain, steps, omega)]
    return csv_table(concatenate([_columns(k, turn) for k, turn in enumerate(turns)]))


def _columns(number: int, turn: response.Response) -> list[Column]:
    """One turn."""
    theta, cam, deflection = turn.steps.theta, turn.steps.s[0], turn.deflection
    return [
        Column("turn", "", "from 0", np.full(len(theta), float(number))),
        Column("angle_deg", "deg", "cam angle", theta / DEGREE),
        Column("time_s", "s", "time from the beginning", (theta + number * FULL_TURN) / turn.omega),
        Column("cam_mm", "mm", "motion of the cam", cam),
        *(Column(f"mass_{i}_mm", "mm", "displacement of a mass", y + cam)
          for i, y in enumerate(deflection, start=1)),
        Column("output_error_mm", "mm", "output minus cam", deflection[-1]),
        Column("output_acceleration_mm_per_s2", "mm/s²", "of the last mass",
               turn.output_acceleration),
        Column("contact_force_n", "N", "between cam and train; negative: the train pulls",
               turn.contact_force),
    ]  # fmt: skip


def _polydyne_csv(answer: TrainResponse, options: RowOptions) -> bytes:
    """The cam motion with which the output moves as the motion of the spec's cam."""
    omega, motion = rad_per_s(options.of(answer)), answer.cam.curve
    theta = _steps(answer, options.points_per_degree).theta
    s = polydyne(answer.spec.train.chain(), motion, omega, theta)
    return csv_table(
        [
            Column("angle_deg", "deg", "cam angle", theta / DEGREE),
            Column("output_mm", "mm", "motion of the last mass", motion.derivatives(theta, 0)[0]),
            Column("cam_mm", "mm", "motion of the cam", s[0]),
            Column("cam_velocity_mm_per_s", "mm/s", "its velocity", s[1] * omega),
            Column("cam_acceleration_mm_per_s2", "mm/s²", "its acceleration", s[2] * omega**2),
        ]
    )


def _response_svg(answer: TrainResponse, options: TrainPictureOptions) -> bytes:
    """Motion of cam and output, the error of the output, its acceleration, the contact force."""
    speed = options.of(answer)
    turn = response.steady(answer.spec.train.chain(), _steps(answer, PER_DEGREE), rad_per_s(speed))
    degrees, error = turn.steps.theta / DEGREE, turn.deflection[-1]
    plots = [
        curve_plot(title, unit, degrees, values)
        for title, unit, values in (
            ("Output", "mm", error + turn.steps.s[0]),
            ("Output less cam", "mm", error),
            ("Acceleration of the output", "mm/s²", turn.output_acceleration),
            ("Contact force", "N", turn.contact_force),
        )
    ]
    title = f"Follower train at {svg.figure(speed)} rpm: {answer.name or answer.id}"
    text = "Periodic response of the train: output, its error and acceleration, the contact force."
    cam = answer.cam.model_copy(update={"speed_rpm": speed})  # the heading names the speed
    return sheet(cam, plots, title, text, options.theme)


def _spectrum_svg(answer: TrainResponse, options: TrainPictureOptions) -> bytes:
    """Residual vibration over the natural frequency, a curve for each run of moves."""
    speed, motion = options.of(answer), answer.cam.curve
    runs = runs_between_dwells(motion.segments)
    angles = {segment.index: segment.angle for segment in motion.segments}
    longest = max((sum(angles[i] for i in run) for run in runs), default=FULL_TURN)
    ratios = np.linspace(0.02, REACH, POINTS) * FULL_TURN / longest  # ω_n/ω
    # Damping ratio of the slowest oscillating mode.
    modes = answer.spec.train.chain().modes
    rates = modes.rates[modes.independent]
    first = rates[int(np.argmax(np.abs(rates.imag) > 0.0))]
    damping = float(np.clip(-first.real / abs(first), 0.0, 0.99))
    curves = [response.residual_spectrum(motion, run, ratios, damping) for run in runs]
    # Amplitudes on a logarithmic axis, down from the power of ten above the largest.
    hertz, wide = ratios * rad_per_s(speed) / FULL_TURN, WIDTH - LEFT - RIGHT
    top = int(np.ceil(np.log10(max((float(curve.max()) for curve in curves), default=1.0))))
    frame = Frame(LEFT, TOP, wide, TALL, top - DECADES, top, 0.0, float(hertz[-1]))
    across, bottom, right = linear(0.0, frame.end), frame.bottom, frame.right
    name = answer.name.strip() or "Follower train"
    about = f"Residual spectrum at {svg.figure(speed)} rpm, damping ratio {svg.figure(damping)}"
    body = [
        svg.text("title", 8.0, 8.0, svg.shorten(name, WIDTH - 16.0, BOLD * svg.TITLE)),
        svg.text("quiet", 8.0, 13.5, f"{about}: amplitude where a dwell begins"),
    ]
    for at, number in ((frame.x(value), number) for value, number in across.ticks):
        body += [svg.line("grid", at, TOP, at, bottom),
                 svg.text("tick", at, bottom + 4.2, number, "middle")]  # fmt: skip
    for power in range(top - DECADES, top + 1):
        level, number = frame.y(float(power)), svg.figure(10.0**power)
        body += [svg.line("grid", LEFT, level, right, level),
                 svg.text("tick", LEFT - 1.6, level + 0.9, number, "end")]  # fmt: skip
    body += [svg.line("axis", LEFT, bottom, right, bottom),
             svg.line("axis", LEFT, TOP, LEFT, bottom)]  # fmt: skip
    for at in (frame.x(mode.natural_frequency_hz) for mode in answer.modes):
        if at <= right:
            body += [svg.line("normal", at, TOP, at, bottom),
                     svg.text("tick halo", at + 1.0, TOP + 3.4, "mode")]  # fmt: skip
    for k, (run, curve) in enumerate(zip(runs, curves, strict=True)):
        powers = np.clip(np.log10(np.maximum(curve, 1e-300)), frame.low, top)
        steps = svg.steps(frame.x(hertz), frame.y(powers), 3)
        body.append(svg.path(DASHES[k % len(DASHES)], steps))
        if k < len(DASHES):  # the legend
            left, low = LEFT + 42.0 * k, bottom + 17.0
            body.append(svg.line(DASHES[k], left, low - 0.9, left + 9.0, low - 0.9))
            body.append(svg.text("tick", left + 11.0, low, f"after segment {run[-1]}"))
    axis = f"Natural frequency, {across.factor}Hz"
    body.append(svg.text("label", LEFT + 0.5 * wide, bottom + 9.4, axis, "middle"))
    body.append(svg.text("label", LEFT, TOP - 2.4, "Amplitude, mm"))
    text = "What an oscillator of every natural frequency is left swinging with by each run."
    return svg.document(WIDTH, bottom + BELOW - 10.0, 1.0, f"Residual spectrum of {name}",
                        text, body, theme=options.theme)  # fmt: skip


CSV, SVG = ("text/csv; charset=utf-8; header=present", ".csv"), ("image/svg+xml", ".svg")
TRAIN_FILES: tuple[FileFormat[TrainResponse, Any], ...] = (
    FileFormat(
        "response.csv", "The response as a table", *CSV, _response_csv, ResponseOptions,
        "Motion of the cam and of every mass, contact force; a cam angle twice where it hits.",
    ),
    FileFormat(
        "response.svg", "The response as diagrams", *SVG, _response_svg, TrainPictureOptions,
        "Output, its error and acceleration, and the contact force over the cam angle.",
    ),
    FileFormat(
        "spectrum.svg", "Residual spectrum of the cam's moves", *SVG, _spectrum_svg,
        TrainPictureOptions,
        "What every natural frequency would be left swinging with, and the train's own ones.",
    ),
    FileFormat(
        "polydyne.csv", "The cam motion for a given output motion", *CSV, _polydyne_csv, RowOptions,
        "A polydyne cam: its motion makes the last mass move as the spec's cam would have it, "
        "exactly, at one speed. It takes 2n + 1 continuous derivatives of that motion for n "
        "masses, and no dampers in the links; 422 says what is missing.", by_default=False,
    ),
)  # fmt: skip
