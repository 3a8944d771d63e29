"""Diagrams over the cam angle, stacked on a sheet under the strip of segments (mm).

Of the motion: s, v, a and j. Of the contact: pressure angle of every roller's path, profile radius
of every flank; with a load contact force and Hertz pressure of every flank, and torque on the
camshaft. The radius has the flank's sign: convex positive, hollow negative as its material sees it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from synthesis.catalogue.followers.base import flat_face
from synthesis.catalogue.followers.kinematics import labelled
from synthesis.catalogue.limits import Claim
from synthesis.design.design import Design, SegmentMotion
from synthesis.exporters.diagrams.plot import (
    FULL,
    Bound,
    Frame,
    Plot,
    Trace,
    claimed_bounds,
    diagram,
    over_turns,
    radii,
)
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import heading
from synthesis.exporters.exporter import design_format
from synthesis.exporters.options import DiagramOptions, PictureOptions, Theme
from synthesis.exporters.samples.cam import Cam, Turn
from synthesis.exporters.samples.columns import force_samples
from synthesis.exporters.samples.sampling import Rows, in_degrees, motion_rows
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

WIDTH, LEFT, RIGHT = 190.0, 21.0, 8.0  # of a sheet, and beside its diagrams [mm]
HEADER, BAND, HEIGHT, GAP, FOOTER = 20.0, 9.4, 42.0, 11.0, 12.0  # mm
SHORT = 7  # what is left of a cut name must have more letters than this
STRIP = Frame(LEFT, HEADER, WIDTH - LEFT - RIGHT, BAND)
DRAWN_PER_DEGREE = 2.0  # a sheet is not drawn more coarsely than this
MEASURED_PER_DEGREE = 20.0  # rows at which the extremes are read
DENSITIES = DRAWN_PER_DEGREE, MEASURED_PER_DEGREE
QUANTITIES = ("displacement", "velocity", "acceleration", "jerk")  # by the order of derivative
# Forces by their names in ``ForceHistory``: title, unit, and of their limits the quantity and name.
FORCES = {
    "contact": ("Contact force N", "N", "contact_force", "contact_force"),
    "pressure": ("Hertz pressure p", "MPa", "pressure_square", "hertz_pressure"),
    "torque": ("Camshaft torque T", "N m", "camshaft_torque", "camshaft_torque"),
}


def sheet(design: Design, plots: Sequence[Plot], title: str, text: str, theme: Theme) -> bytes:
    """The sheet of a design; ``title`` and ``text`` are for those who do not see it."""
    above, unit = heading(design, LEFT, WIDTH - RIGHT, 1.0), design.spec.follower.travel.unit
    return stack(design.motion, unit, above, plots, (title, text), theme)


def stack(
    motion: Sequence[SegmentMotion],
    unit: str,
    above: Sequence[str],
    plots: Sequence[Plot],
    title_and_text: tuple[str, str],
    theme: Theme,
    turns: int = 1,
) -> bytes:
    """The same under a heading of ``above``; ``unit``: of the segments' levels.

    ``turns``: over how many turns of the cam motion and diagrams run.
    """
    strip = replace(STRIP, end=FULL * turns)
    body = [*above, *grounds(motion, strip), *_band(motion, strip, unit)]
    frame = strip
    for k, plot in enumerate(plots):
        top = HEADER + BAND + GAP - 2.0 + k * (HEIGHT + GAP)
        frame = replace(strip, top=top, height=HEIGHT)
        body += [*grounds(motion, frame), *diagram(plot, frame)]
    body += angle_axis(frame)
    return svg.document(WIDTH, frame.bottom + FOOTER, 1.0, *title_and_text, body, theme=theme)


def moving_segments(motion: Sequence[SegmentMotion]) -> list[SegmentMotion]:
    """Those that extend over some angle."""
    return [segment for segment in motion if segment.angle_deg > 0.0]


def grounds(motion: Sequence[SegmentMotion], frame: Frame) -> list[str]:
    """A ground for what is drawn over the cam angle: dwells shaded, borders of segments drawn."""
    segments = moving_segments(motion)
    starts = [frame.x(start) for start in (*(each.start_deg for each in segments), frame.end)]
    body = [
        svg.box("rest", a, frame.top, b - a, frame.height)
        for segment, (a, b) in zip(segments, pairwise(starts), strict=True)
        if segment.kind == "dwell"
    ]
    return body + [svg.line("border", x, frame.top, x, frame.bottom) for x in starts]


def _band(motion: Sequence[SegmentMotion], strip: Frame, unit: str) -> list[str]:
    """The strip of segments: what each does and how, as far as there is room."""
    body = [svg.line("border", LEFT, y, WIDTH - RIGHT, y) for y in (HEADER, HEADER + BAND)]
    segments = moving_segments(motion)
    for segment in segments:
        width = strip.x(segment.angle_deg) - LEFT
        middle = strip.x(segment.start_deg) + 0.5 * width
        name = svg.first_fitting(_names(segment, unit), width - 1.0, svg.LABEL)
        if name:
            body.append(svg.text("label", middle, HEADER + 4.0, name, "middle"))
        law = segment.law.replace("_", " ")
        if segment.kind == "dwell":  # lifts leave residues
            law = f"at {svg.with_unit(round(segment.levels[0], 9), unit)}"
        text = svg.shorten(law, width - 1.0, svg.TICK)
        if len(text) > SHORT or text == law:
            body.append(svg.text("tick", middle, HEADER + 7.8, text, "middle"))
    # cam angles of the borders; the last one, the turn's end, is always there
    *angles, end = [f"{svg.figure(s.start_deg, 6)}°" for s in segments] + [f"{strip.end:.0f}°"]
    room = strip.right - 0.5 * svg.width_of(end, svg.TICK)
    at, y = [strip.x(s.start_deg) for s in segments], HEADER - 1.3
    body += svg.spaced_texts(at, angles, y, 1.0, room)
    return [*body, svg.text("tick", strip.right, y, end, "middle")]


def _names(segment: SegmentMotion, unit: str) -> list[str]:
    """What a segment does, the longest text first."""
    angle = f"{svg.figure(segment.angle_deg, 6)}°"
    if segment.kind == "dwell":
        return [f"dwell {angle}", "dwell"]
    start, end = segment.levels
    lift = svg.with_unit(abs(end - start), unit)
    return [f"{segment.kind} {lift} in {angle}", f"{segment.kind} {lift}", segment.kind]


def angle_axis(frame: Frame, every: int = 1, name: str = "Cam angle") -> list[str]:
    """Numbers and name of the abscissa under a diagram; ``every``: one of how many numbers."""
    body, bottom = list[str](), frame.bottom
    for degrees in frame.angles[::every]:
        x = frame.x(float(degrees))
        body.append(svg.line("axis", x, bottom, x, bottom + 1.2))
        body.append(svg.text("tick", x, bottom + 4.4, f"{degrees}", "middle"))
    middle = frame.left + 0.5 * frame.width
    return [*body, svg.text("label", middle, bottom + 9.2, f"{name}, degrees", "middle")]


def _motion(design: Design, options: DiagramOptions) -> bytes:
    cam, above = Cam.of(design), heading(design, LEFT, WIDTH - RIGHT, 1.0)
    limits = partial(motion_bounds, design)
    return motion_sheet(cam, design.name or design.id, design.motion, above, options, limits)


def motion_sheet(
    turn: Turn,
    name: str,
    motion: Sequence[SegmentMotion],
    above: Sequence[str],
    options: DiagramOptions,
    limits: Callable[[int], Sequence[Bound]] = lambda order: (),
) -> bytes:
    """The four diagrams of a motion under a heading; ``limits``: of each derivative of s."""
    # as many rows on the sheet, whatever the number of turns
    per_degree = max(options.count / FULL, DRAWN_PER_DEGREE / options.turns)
    unit, advance = turn.travel.unit, turn.advance / turn.travel.per_unit
    plots = [
        over_turns(motion_plot(turn, k, per_degree, limits(k)), options.turns, step)
        for k, step in enumerate((advance, 0.0, 0.0, 0.0))
    ]
    steps = {"start_deg": FULL, f"s_start_{unit}": advance, f"s_end_{unit}": advance}
    motion = [
        each.model_copy(update={n: getattr(each, n) + k * step for n, step in steps.items()})
        for k in range(options.turns)
        for each in motion
    ]
    text = "Displacement, velocity, acceleration and jerk of the follower over the cam angle."
    titles = (f"Motion of {name}", text)
    return stack(motion, unit, above, plots, titles, options.theme, options.turns)


def motion_bounds(design: Design, order: int) -> list[Bound]:
    """The bounds of the spec's limits on a derivative of s by time."""
    return claimed_bounds(design, lambda claim: claim.quantity == QUANTITIES[order])


def motion_plot(
    turn: Turn, order: int, per_degree: float = DRAWN_PER_DEGREE, limits: Sequence[Bound] = ()
) -> Plot:
    """The diagram of a derivative of s by time, drawn with so many rows per degree."""

    def value(rows: Rows) -> Array:
        return np.asarray(turn.derivatives(rows.theta, rows.left)[order] * turn.rate(order))

    # Where a lower derivative jumps the value is infinite, with the sign of the jump.
    theta = turn.joints.breaking(order - 1)
    lower = turn.joints.order[turn.joints.order < order]
    left, right = (turn.motion.derivatives(theta, 3, side) for side in ("left", "right"))
    jump = (right - left)[lower, np.arange(len(theta))]
    curve, fine = _traces(turn, value, per_degree)
    return Plot(
        title=f"{QUANTITIES[order].capitalize()} {'svaj'[order]}",
        unit=svg.unit(turn.travel.derivative_unit(order)),
        curve=curve,
        fine=fine,
        infinite=Trace.infinite(in_degrees(theta), jump),
        limits=limits,
        ends=(("max", True), ("min", False))[: 2 if order else 1],
    )


def _contact(design: Design, options: PictureOptions) -> bytes:
    cams = tuple(Cam.of(design).flanks())
    ways = {cam.flank.path: cam for cam in reversed(cams)}
    plots = [pressure_plot(design, ways[path]) for path in reversed(ways)]
    plots += [radius_plot(design, cam) for cam in cams]
    forces = list(force_plots(design, cams[0]))
    title = f"Contact of {design.name or design.id}"
    text = "Pressure angle and radius of curvature of the profile over the cam angle."
    if forces:
        text = f"{text[:-1]}, contact force and torque."
    return sheet(design, [*plots, *forces], title, text, options.theme)


def pressure_plot(design: Design, cam: Cam) -> Plot:
    """The pressure angle along the traced curve of a flank."""
    path = cam.flank.path
    curve, fine = _traces(cam, lambda rows: cam.at(rows.theta, rows.left).pressure_angle / DEGREE)
    limits = claimed_bounds(
        design,
        lambda claim: claim.quantity == "pressure_angle" and claim.path == path,
        lambda _, value: value / DEGREE,
    )
    return Plot(f"Pressure angle α {path}".strip(), "°", curve, fine, limits=limits)


def radius_plot(design: Design, cam: Cam) -> Plot:
    """The radius of curvature of a flank: even in curvature, along a flat face in the radius."""
    name, side, distance = cam.flank.name, cam.flank.side, cam.flank.distance
    title = f"Profile radius ρ {name}".strip()
    wanted = {labelled(limit, name) for limit in ("profile_radius", "cutter_radius")}
    limits = claimed_bounds(
        design, lambda claim: claim.limit in wanted, lambda _, value: side * value
    )
    theta = cam.joints.breaking(1)
    if flat_face(cam.follower) is not None:
        # Along a face nothing can be hollow. Where the velocity jumps the face rocks on a corner,
        # or would have to leave the cam.
        left, right = (cam.motion.derivatives(theta, 3, side) for side in ("left", "right"))
        curve, fine = _traces(cam, lambda rows: cam.at(rows.theta, rows.left).radius)
        infinite = Trace.infinite(in_degrees(theta), right[1] - left[1])
        ends = ("min", False), ("max", True)
        return Plot(title, "mm", curve, fine, infinite, limits, ends, bad=(-np.inf, 0.0))
    curve, fine = _traces(cam, lambda rows: side * cam.at(rows.theta, rows.left).curvature)
    # A corner of the traced curve is infinitely convex or hollow, as the material sees it; the
    # curve of a ccw cam runs clockwise.
    before, after = cam.at(theta, np.ones(len(theta), dtype=bool)), cam.at(theta)
    turn = before.normal_x * after.normal_y - before.normal_y * after.normal_x
    mirror = 1.0 if cam.rotation == "ccw" else -1.0
    convex = [("convex", True)] if fine.values.max() > 0.0 else []
    hollow = [("hollow", False)] if fine.values.min() < 0.0 else []
    return Plot(
        title, "mm", curve, fine,
        infinite=Trace.infinite(in_degrees(theta), -mirror * side * turn),
        limits=limits,
        ends=convex + hollow,
        labels=radii(distance),
        bad=(1.0 / distance, np.inf) if distance > 0.0 else (),
    )  # fmt: skip


def force_plots(design: Design, cam: Cam) -> Iterator[Plot]:
    """The diagrams of a design's forces; none where the spec has no load."""
    rows = [motion_rows(cam, 360.0 * density) for density in DENSITIES]
    samples = [force_samples(design, cam, each) for each in rows]
    for name, (title, unit, quantity, limit) in FORCES.items():
        for flank in (flank for force, flank in samples[0] if force == name):
            curve, fine = (
                Trace(each.degrees, each.side, forces[name, flank])
                for each, forces in zip(rows, samples, strict=True)
            )
            limits = claimed_bounds(design, partial(_bounds, quantity, labelled(limit, flank)))
            yield Plot(f"{title} {flank}".strip(), unit, curve, fine, limits=limits)


def _bounds(quantity: str, limit: str, claim: Claim) -> bool:
    """Whether a claim bounds a quantity for a limit, from either side."""
    whole = claim.limit.removesuffix("_min").removesuffix("_max")
    return claim.quantity == quantity and whole == limit


def _traces(
    turn: Turn, value: Callable[[Rows], Array], drawn: float = DRAWN_PER_DEGREE
) -> Iterator[Trace]:
    """As it is drawn, and as its extremes are read."""
    for density in (drawn, MEASURED_PER_DEGREE):
        rows = motion_rows(turn, 360.0 * density)
        yield Trace(rows.degrees, rows.side, value(rows))


MOTION = design_format("motion", "svg", _motion, DiagramOptions)
CONTACT = design_format("picture", "contact.svg", _contact, PictureOptions)
