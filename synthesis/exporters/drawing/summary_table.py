"""The summary of a design as tables of text: one source for report, datasheet and terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from synthesis.design.design import Certificate, Design, ForcePeak, Forces
from synthesis.design.summary import (
    CamGeometry,
    Coefficients,
    DerivativeSummary,
    FlankGeometry,
    MotionSummary,
    MoveSummary,
    PeakValue,
)
from synthesis.exporters.drawing.canvas import figure, with_unit
from synthesis.units import split_unit

DIGITS = 5  # significant ones of a figure
ROUNDING = 1e-12  # of a torque's rms: a mean that is smaller is 0
VERDICTS = {
    "optimal": "certified, and proven to be within the tolerance of the best possible",
    "feasible": "certified: every limit holds at every cam angle",
    "unsolved": "no cam was found, and that there is none is not proven",
    "infeasible": "proven: no cam keeps these limits",
}
COEFFICIENTS = ("Cv", "Ca", "Cj", "Cva", "Ea", "Ej")
COEFFICIENTS_NOTE = (
    "With the lift and the angle of a move as 1: peaks of velocity, acceleration and jerk, of "
    "velocity times acceleration, and mean squares of acceleration and jerk. The reference is the "
    "named law that is usual between such ends (VDI 2143: R rest, G constant velocity, U turn, "
    "B motion)."
)
SPOKEN = {"s0_mm": "roller centre above the axis, s0"}  # names of the wire that say too little


class TextTable(NamedTuple):
    """A table of text, its first column of names; ``note``: what a reader may have to know."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def summary_tables(design: Design) -> list[TextTable]:
    """Motion, coefficients, geometry, forces: those that a design has."""
    tables = []
    if design.motion_summary is not None:
        tables.append(motion_table(design, design.motion_summary))
        tables.append(coefficient_table(design, design.motion_summary))
    if design.geometry is not None:
        tables.append(figures_table(geometry_figures(design.geometry), "Geometry"))
    if design.forces is not None:
        tables.append(figures_table(force_figures(design.forces), "Forces"))
    return tables


def derivatives(design: Design, summary: MotionSummary) -> Iterator[tuple[str, DerivativeSummary]]:
    """Velocity, acceleration and jerk by name: of the turn, then of every move.

    Where one is infinite, since that below it jumps, its peaks are those between the jumps.
    """
    parts: list[tuple[str, MotionSummary | MoveSummary]] = [("turn", summary)]
    parts += [(move_name(design, move), move) for move in summary.moves]
    for name, part in parts:
        for word in ("velocity", "acceleration", "jerk"):
            found: DerivativeSummary = getattr(part, word)
            yield f"{word}, {name}{' between jumps' * (found.rms is None)}", found


def motion_table(design: Design, summary: MotionSummary) -> TextTable:
    """Peaks, rms and jumps: of the turn, and of every move."""
    head = ("Derivative", "unit", "largest", "at", "smallest", "at", "rms", "jumps")
    rows = [
        (
            name, found.unit, figure(found.largest.value, DIGITS), degrees(found.largest),
            figure(found.smallest.value, DIGITS), degrees(found.smallest),
            "infinite" if found.rms is None else figure(found.rms, DIGITS), jumps(found),
        )
        for name, found in derivatives(design, summary)
    ]  # fmt: skip
    return TextTable("Motion", head, rows)


def jumps(found: DerivativeSummary) -> str:
    """How many jumps, and how large."""
    if found.largest_jump is None:
        return "none"
    return f"{found.jumps}, up to {figure(abs(found.largest_jump.value), 4)}"


def coefficient_table(design: Design, summary: MotionSummary) -> TextTable:
    """The coefficients of every move and, below, of the law that is usual between its ends."""
    rows = []
    for move in summary.moves:
        rows.append((move_name(design, move), *_coefficients(move.coefficients)))
        reference = move.reference
        if reference is not None:
            name = f"{reference.law.replace('_', ' ')}, {reference.ends}"
            rows.append((f"  reference: {name}", *_coefficients(reference.coefficients)))
    return TextTable(
        "Coefficients", ("Move and reference law", *COEFFICIENTS), rows, COEFFICIENTS_NOTE
    )


def _coefficients(found: Coefficients) -> Iterator[str]:
    for name in COEFFICIENTS:
        value = getattr(found, name)
        yield "infinite" if value is None else figure(value, DIGITS)


def move_name(design: Design, move: MoveSummary) -> str:
    """A move by what it does and where: rise 0–120°."""
    segment = design.motion[move.segment]
    end = segment.start_deg + segment.angle_deg
    return f"{segment.kind} {figure(segment.start_deg)}–{figure(end)}°"


class Figure(NamedTuple):
    """A figure by its name, with unit, and the cam angle where it is reached, if at one [deg]."""

    name: str
    value: float | str
    unit: str = ""
    angle_deg: float | None = None


def dimension_figures(design: Design) -> Iterator[Figure]:
    """The dimensions of cam and machine, by names for people."""
    for name, value in design.dimensions.items():
        stem, unit = split_unit(name)
        yield Figure(SPOKEN.get(name, stem.replace("_", " ")), value, unit)


def figures_table(found: Iterable[Figure], title: str) -> TextTable:
    """Figures as text: name, value with unit, angle."""
    rows = [
        (
            each.name,
            each.value if isinstance(each.value, str) else with_unit(each.value, each.unit),
            "" if each.angle_deg is None else f"{figure(each.angle_deg, DIGITS)}°",
        )
        for each in found
    ]
    return TextTable(title, ("Figure", "value", "at"), rows)


def geometry_figures(geometry: CamGeometry) -> Iterator[Figure]:
    """Radii, rollers, perimeter, area; the mass where it is known."""
    yield Figure("base radius", geometry.base_radius_mm, "mm")
    yield Figure("prime radius", geometry.prime_radius_mm, "mm")
    for flank in geometry.flanks:
        yield from _flank(flank)
    mass = geometry.mass_properties
    if mass is not None:
        yield Figure("mass", mass.mass_kg, "kg")
        yield from _place("centre of gravity", mass.centre_of_gravity_mm)
        yield Figure("moment of inertia", mass.moment_of_inertia_kg_m2, "kg m²")


def _flank(flank: FlankGeometry) -> Iterator[Figure]:
    name = f" {flank.flank}" if flank.flank else ""
    hollows = f"{name} (of {flank.hollows})" if flank.hollows > 1 else name

    def at(title: str, peak: PeakValue | None, unit: str, otherwise: str = "") -> Iterator[Figure]:
        if peak is not None:
            yield Figure(f"{title}{name}", peak.value, unit, peak.angle_deg)
        elif otherwise:
            yield Figure(f"{title}{name}", otherwise)

    yield from at("outer radius", flank.largest_radius_mm, "mm")
    yield from at("least convex radius", flank.convex_radius_mm, "mm", "nowhere convex")
    hollow = flank.hollow_radius_mm
    if hollow is None:
        yield Figure(f"least hollow radius{name}", "no hollow")
    else:
        yield Figure(f"least hollow radius{hollows}", hollow.value, "mm", hollow.angle_deg)
    yield from at("sliding speed", flank.sliding_speed_mm_per_s, "mm/s")
    yield from at("roller speed", flank.roller_speed_rpm, "rpm")
    yield from at("roller acceleration", flank.roller_acceleration_rad_per_s2, "rad/s²")
    yield Figure(f"perimeter{name}", flank.perimeter_mm, "mm")
    yield Figure(f"area{name}", flank.area_mm2, "mm²")
    yield from _place(f"centroid{name}", flank.centroid_mm)
    yield Figure(f"polar moment of area{name}", flank.polar_moment_mm4, "mm⁴")


def _place(name: str, at: tuple[float, float]) -> Iterator[Figure]:
    # a millionth of a millimetre: what is on the axis is there but for rounding
    for axis, value in zip("xy", at, strict=True):
        yield Figure(f"{name} {axis}", round(value, 6), "mm")


def force_figures(forces: Forces) -> Iterator[Figure]:
    """Contact force and pressure of every flank, torque, power, energy, float."""
    for each in forces.flanks:
        name = f" {each.flank}" if each.flank else ""
        yield _force(f"contact force{name}, largest", each.largest_n, "N")
        yield _force(f"contact force{name}, least", each.smallest_n, "N")
        if each.largest_pressure_mpa is not None:
            yield _force(f"Hertz pressure{name}", each.largest_pressure_mpa, "MPa")
    torque = forces.torque
    yield _force("camshaft torque, largest", torque.largest_n_m, "N m")
    yield _force("camshaft torque, least", torque.smallest_n_m, "N m")
    yield Figure("camshaft torque, rms", torque.rms_n_m, "N m")
    # what comes back whole leaves a mean that is rounding
    works = abs(torque.mean_n_m) > ROUNDING * torque.rms_n_m
    yield Figure("mean power", torque.power_w if works else 0.0, "W")
    yield Figure("energy of a turn", torque.work_j if works else 0.0, "J")
    if forces.float_onset_rpm is not None:
        yield Figure("floats from", forces.float_onset_rpm, "rpm")


def _force(name: str, peak: ForcePeak | None, unit: str) -> Figure:
    if peak is None:
        return Figure(name, "infinite")
    return Figure(name, peak.value, unit, peak.angle_deg)


def degrees(peak: PeakValue) -> str:
    """Where a peak is."""
    return f"{figure(peak.angle_deg, DIGITS)}°"


def certificate_words(certificate: Certificate) -> str:
    """What was proven, in sentences."""
    holds = (
        "Every limit holds at every cam angle: extremes are enclosed by interval arithmetic."
        if certificate.certified
        else "Not every limit holds."
    )
    if certificate.lower_bound is None or certificate.value is None:
        return f"{holds} How near this cam is to the best possible is not known."
    stem, unit = split_unit(certificate.objective)
    name, valid = stem.replace("_", " "), certificate.bound_valid_for
    value, bound = (
        with_unit(each, unit, 7).rstrip() for each in (certificate.value, certificate.lower_bound)
    )
    if certificate.infimum:
        return (
            f"{holds} The {name} is {value}; its infimum lies between {bound} and that, over "
            f"{valid}."
        )
    gap = figure(round(100.0 * (certificate.gap or 0.0), 7), 3)
    return f"{holds} The {name} is {value}; no cam is below {bound} (gap {gap} %), over {valid}."
