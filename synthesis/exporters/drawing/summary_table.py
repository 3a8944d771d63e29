"""The summary of a design as tables of text: one source for report, datasheet and terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
DASH = "–"
VERDICTS = {
    "optimal": "certified, and proven to be within the tolerance of the best possible",
    "feasible": "certified: every limit holds at every cam angle",
    "unsolved": "no cam was found, and that there is none is not proven",
    "infeasible": "proven: no cam keeps these limits",
}
COEFFICIENTS = ("Cv", "Ca", "Cj", "Cva", "Ea", "Ej")


class TextTable(NamedTuple):
    """A table of text, its first column of names."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def summary_tables(design: Design) -> list[TextTable]:
    """Motion, coefficients, geometry, forces: those that a design has."""
    tables = []
    if design.motion_summary is not None:
        tables.append(motion_table(design, design.motion_summary))
        tables.append(coefficient_table(design, design.motion_summary))
    if design.geometry is not None:
        tables.append(geometry_table(design.geometry))
    if design.forces is not None:
        tables.append(force_table(design.forces))
    return tables


def motion_table(design: Design, summary: MotionSummary) -> TextTable:
    """Peaks, rms and jumps: of the turn, and of every move where there are several."""
    head = ("Motion", "largest", "at", "smallest", "at", "rms", "jumps")
    rows = []
    parts: list[tuple[str, MotionSummary | MoveSummary]] = [("turn", summary)]
    parts += [(move_name(design, move), move) for move in summary.moves]
    for name, part in parts:
        for word in ("velocity", "acceleration", "jerk"):
            found: DerivativeSummary = getattr(part, word)
            rows.append((
                f"{word} {found.unit}, {name}", figure(found.largest.value, DIGITS),
                degrees(found.largest), figure(found.smallest.value, DIGITS),
                degrees(found.smallest),
                "infinite" if found.rms is None else figure(found.rms, DIGITS), _jumps(found),
            ))  # fmt: skip
    return TextTable("Motion", head, rows)


def _jumps(found: DerivativeSummary) -> str:
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
    return TextTable("Coefficients", ("Move and reference law", *COEFFICIENTS), rows)


def _coefficients(found: Coefficients) -> Iterator[str]:
    for name in COEFFICIENTS:
        value = getattr(found, name)
        yield "infinite" if value is None else figure(value, DIGITS)


def move_name(design: Design, move: MoveSummary) -> str:
    """A move by what it does and where: rise 0–120°."""
    segment = design.motion[move.segment]
    end = segment.start_deg + segment.angle_deg
    return f"{segment.kind} {figure(segment.start_deg)}–{figure(end)}°"


def geometry_table(geometry: CamGeometry) -> TextTable:
    """Radii, perimeter, area, hollows, rollers; the mass where it is known."""
    rows: list[tuple[str, str, str]] = [
        ("base radius", with_unit(geometry.base_radius_mm, "mm"), ""),
        ("prime radius", with_unit(geometry.prime_radius_mm, "mm"), ""),
    ]
    for flank in geometry.flanks:
        rows += _flank(flank)
    mass = geometry.mass_properties
    if mass is not None:
        rows += [
            ("mass", with_unit(mass.mass_kg, "kg", DIGITS), ""),
            ("centre of gravity", _place(mass.centre_of_gravity_mm), "x, y"),
            ("moment of inertia", f"{figure(mass.moment_of_inertia_kg_m2, DIGITS)} kg m²", ""),
        ]
    return TextTable("Geometry", ("Geometry", "value", "at"), rows)


def _flank(flank: FlankGeometry) -> Iterator[tuple[str, str, str]]:
    name = f" {flank.flank}" if flank.flank else ""

    def at(
        title: str, peak: PeakValue | None, unit: str, otherwise: str = ""
    ) -> Iterator[tuple[str, str, str]]:
        if peak is not None:
            yield f"{title}{name}", f"{figure(peak.value, DIGITS + 1)} {unit}", degrees(peak)
        elif otherwise:
            yield f"{title}{name}", otherwise, ""

    hollows = f" ({flank.hollows} hollows)" if flank.hollows > 1 else ""
    yield from at("outer radius", flank.largest_radius_mm, "mm")
    yield from at("least convex radius", flank.convex_radius_mm, "mm", "nowhere convex")
    yield from at(f"least hollow radius{hollows}", flank.hollow_radius_mm, "mm", "no hollow")
    yield from at("sliding speed", flank.sliding_speed_mm_per_s, "mm/s")
    yield from at("roller speed", flank.roller_speed_rpm, "rpm")
    yield from at("roller acceleration", flank.roller_acceleration_rad_per_s2, "rad/s²")
    yield f"perimeter{name}", with_unit(flank.perimeter_mm, "mm"), ""
    yield f"area{name}", f"{figure(flank.area_mm2, DIGITS + 1)} mm²", ""
    yield f"centroid{name}", _place(flank.centroid_mm), "x, y"
    yield f"polar moment of area{name}", f"{figure(flank.polar_moment_mm4, DIGITS)} mm⁴", ""


def _place(at: tuple[float, float]) -> str:
    # a thousandth of a millimetre: what is on the axis is there but for rounding
    return ", ".join(figure(round(each, 3), 6) for each in at) + " mm"


def force_table(forces: Forces) -> TextTable:
    """Contact force and pressure of every flank, torque, power, energy, float."""
    rows: list[tuple[str, str, str]] = []
    for each in forces.flanks:
        name = f" {each.flank}" if each.flank else ""
        rows.append(_force(f"contact force{name}, largest", each.largest_n, "N"))
        rows.append(_force(f"contact force{name}, least", each.smallest_n, "N"))
        if each.largest_pressure_mpa is not None:
            rows.append(_force(f"Hertz pressure{name}", each.largest_pressure_mpa, "MPa"))
    torque = forces.torque
    rows.append(_force("camshaft torque, largest", torque.largest_n_m, "N m"))
    rows.append(_force("camshaft torque, least", torque.smallest_n_m, "N m"))
    rows += [
        ("camshaft torque, rms", with_unit(torque.rms_n_m, "N m", DIGITS), ""),
        ("mean power", with_unit(torque.power_w, "W", DIGITS), ""),
        ("energy of a turn", with_unit(torque.work_j, "J", DIGITS), ""),
    ]
    if forces.float_onset_rpm is not None:
        rows.append(("floats from", with_unit(forces.float_onset_rpm, "rpm", DIGITS), ""))
    return TextTable("Forces", ("Forces", "value", "at"), rows)


def _force(name: str, peak: ForcePeak | None, unit: str) -> tuple[str, str, str]:
    if peak is None:
        return name, "infinite", ""
    return name, with_unit(peak.value, unit, DIGITS), f"{figure(peak.angle_deg, DIGITS)}°"


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
    gap = figure(100.0 * (certificate.gap or 0.0), 3)
    return f"{holds} The {name} is {value}; no cam is below {bound} (gap {gap} %), over {valid}."
