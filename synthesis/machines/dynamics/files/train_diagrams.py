"""A follower train's response over the cam angle, and the motion's residual spectrum, as SVG."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synthesis.catalogue.limits.residual_vibration import runs_between_dwells
from synthesis.exporters.diagrams.plot import NOWHERE, Plot, linear
from synthesis.exporters.diagrams.readings import Trace
from synthesis.exporters.diagrams.sheet import sheet
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import BOLD
from synthesis.exporters.drawing.theme import Theme
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.files.train_csv import TrainOptions, responses
from synthesis.machines.dynamics.report import TrainResponse, output_acceleration
from synthesis.machines.dynamics.spectrum import residual_spectrum
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

WIDTH, LEFT, RIGHT, TOP, TALL, BELOW = 190.0, 24.0, 8.0, 24.0, 74.0, 34.0
POINTS, REACH, DECADES = 900, 8.0, 4  # swings during the longest run that are drawn
DASHES = ("line curve", "line phase", "line prime", "line circle")


def response_svg(found: TrainResponse, options: TrainOptions, theme: Theme = "auto") -> bytes:
    """Motion of cam and output, the error of the output, its acceleration, the contact force."""
    turn = responses(found, replace(options, turns=0))[0]
    degrees, side = turn.theta / DEGREE, np.zeros(len(turn.theta), dtype=np.int64)

    def plot(title: str, unit: str, values: Array) -> Plot:
        trace = Trace(degrees, side, values)
        return Plot(title, unit, trace, trace, NOWHERE)

    plots = [
        plot("Output", "mm", turn.deflection[-1] + turn.steps.s[0]),
        plot("Output less cam", "mm", turn.deflection[-1]),
        plot("Acceleration of the output", "mm/s²", output_acceleration(turn)),
        plot("Contact force", "N", turn.contact_force),
    ]
    speed = options.speed_rpm or found.spec.cam.speed_rpm
    title = f"Follower train at {svg.figure(speed)} rpm: {found.name or found.id}"
    told = "Periodic response of the train: output, its error and acceleration, the contact force."
    cam = found.cam.model_copy(update={"speed_rpm": speed})  # the heading names the speed
    return sheet(cam, plots, title, told, theme)


def spectrum_svg(
    found: TrainResponse, speed_rpm: float | None = None, theme: Theme = "auto"
) -> bytes:
    """Residual vibration over the natural frequency, a curve for each run of moves.

    ``speed_rpm``: None: the speed that the cam was designed for.
    """
    speed = speed_rpm or found.spec.cam.speed_rpm
    motion, chain = found.cam.curve, found.spec.train.chain()
    spans = runs_between_dwells(motion.segments)
    by_index = {s.index: s for s in motion.segments}
    longest = max((sum(by_index[i].angle for i in run) for run in spans), default=FULL_TURN)
    swings = np.linspace(0.02, REACH, POINTS)  # during the longest run
    damping = _damping(chain)
    curves = [
        residual_spectrum(motion, run, swings * FULL_TURN / longest, damping) for run in spans
    ]
    hertz = swings * FULL_TURN / longest * rad_per_s(speed) / FULL_TURN
    told = f"Residual spectrum at {svg.figure(speed)} rpm, damping ratio {svg.figure(damping)}"
    return _drawn(found, hertz, curves, [run[-1] for run in spans], told, theme)


def _damping(chain: Chain) -> float:
    """Damping ratio of the slowest oscillating mode."""
    rates = chain.modes.rates[chain.modes.independent]
    first = rates[int(np.argmax(np.abs(rates.imag) > 0.0))]
    return float(np.clip(-first.real / abs(first), 0.0, 0.99))


def _drawn(
    found: TrainResponse,
    hertz: Array,
    curves: list[Array],
    ends: list[int],
    told: str,
    theme: Theme,
) -> bytes:
    wide = WIDTH - LEFT - RIGHT
    top = int(np.ceil(np.log10(max((float(curve.max()) for curve in curves), default=1.0))))
    across, bottom = linear(0.0, float(hertz[-1])), TOP + TALL

    def x(value: float | Array) -> Array:
        return np.asarray(LEFT + wide * np.asarray(value) / hertz[-1])

    def y(value: float | Array) -> Array:
        down = (top - np.log10(np.maximum(value, 1e-300))) / DECADES
        return np.asarray(TOP + TALL * np.clip(down, 0.0, 1.0))

    name = found.name.strip() or "Follower train"
    body = [
        svg.text("title", 8.0, 8.0, svg.shortened(name, WIDTH - 16.0, BOLD * svg.TITLE)),
        svg.text("quiet", 8.0, 13.5, f"{told}: amplitude where a dwell begins"),
    ]
    for value, number in across.ticks:
        body.append(svg.line("grid", float(x(value)), TOP, float(x(value)), bottom))
        body.append(svg.text("tick", float(x(value)), bottom + 4.2, number, "middle"))
    for power in range(top - DECADES, top + 1):
        level = float(y(10.0**power))
        body.append(svg.line("grid", LEFT, level, WIDTH - RIGHT, level))
        body.append(svg.text("tick", LEFT - 1.6, level + 0.9, svg.figure(10.0**power), "end"))
    body += [svg.line("axis", LEFT, bottom, WIDTH - RIGHT, bottom),
             svg.line("axis", LEFT, TOP, LEFT, bottom)]  # fmt: skip
    for mode in found.modes:
        if mode.natural_frequency_hz <= hertz[-1]:
            at = float(x(mode.natural_frequency_hz))
            body.append(svg.line("normal", at, TOP, at, bottom))
            body.append(svg.text("tick halo", at + 1.0, TOP + 3.4, "mode"))
    for k, curve in enumerate(curves):
        body.append(svg.path(DASHES[k % len(DASHES)], svg.steps(x(hertz), y(curve), 3)))
    axis = f"Natural frequency, {across.factor}Hz"
    body.append(svg.text("label", LEFT + 0.5 * wide, bottom + 9.4, axis, "middle"))
    body.append(svg.text("label", LEFT, TOP - 2.4, "Amplitude, mm"))
    for k, end in enumerate(ends[: len(DASHES)]):
        left, low = LEFT + 42.0 * k, bottom + 17.0
        body.append(svg.line(DASHES[k], left, low - 0.9, left + 9.0, low - 0.9))
        body.append(svg.text("tick", left + 11.0, low, f"after segment {end}"))
    described = "What an oscillator of every natural frequency is left swinging with by each run."
    return svg.document(WIDTH, bottom + BELOW - 10.0, 1.0, f"Residual spectrum of {name}",
                        described, body, theme=theme)  # fmt: skip
