"""What an engineer reads first: peaks, coefficients and the reference law; the cam as a body.

Every figure is computed in floating point on the finished cam, to about 1e-12; what is *proven* of
a cam is in its certificate. Formulas and sources: ``docs/datasheet.md``.
"""

from __future__ import annotations

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, doc


class PeakValue(AnswerModel):
    """A largest or smallest value with its sign, and where it is reached first."""

    value: float = doc("The value.")
    angle_deg: float = doc("Cam angle.")
    segment: int = doc("Segment of the program, from 0.")


class DerivativeSummary(AnswerModel):
    """Velocity, acceleration or jerk; where the one below it jumps, it is infinite.

    Then ``rms`` is null, and the peaks are those between the jumps.
    """

    unit: str = doc("Unit of the values.")
    largest: PeakValue = doc("Largest value.")
    smallest: PeakValue = doc("Smallest value.")
    rms: float | None = doc("Root mean square; null: infinite.")
    jumps: int = doc("Number of cam angles at which it jumps.")
    largest_jump: PeakValue | None = doc("Largest jump, value after less value before.")


class Coefficients(AnswerModel):
    """Dimensionless figures of a move, referred to its lift and angle; null: infinite."""

    Cv: float | None = doc("Largest |g'|: v / (h/T).")
    Ca: float | None = doc("Largest |g''|: a / (h/T²).")
    Cj: float | None = doc("Largest |g'''|: j / (h/T³).")
    Cva: float | None = doc("Largest |g' g''|: torque of inertia.")
    Ea: float | None = doc("Mean square of g''.")
    Ej: float | None = doc("Mean square of g'''.")


class ReferenceLaw(AnswerModel):
    """The named law that is usual between these ends, on the same lift and angle."""

    law: str = doc("Its name.")
    ends: str = doc("Kinds of the ends by VDI 2143: R rest, G constant velocity, U turn, B motion.")
    source: str = doc("Where the law was published.")
    coefficients: Coefficients = doc("Its figures.")


class MoveSummary(AnswerModel):
    """One segment that moves."""

    segment: int = doc("Segment of the program, from 0.")
    velocity: DerivativeSummary = doc("Velocity on it.")
    acceleration: DerivativeSummary = doc("Acceleration on it.")
    jerk: DerivativeSummary = doc("Jerk on it.")
    coefficients: Coefficients = doc("Its figures, of a table referred to its range.")
    reference: ReferenceLaw | None = doc(
        "What to compare them with; null of a table that moves both ways."
    )


class MotionSummary(AnswerModel):
    """The motion in numbers, at the cam's speed."""

    velocity: DerivativeSummary = doc("Velocity over the turn.")
    acceleration: DerivativeSummary = doc("Acceleration over the turn.")
    jerk: DerivativeSummary = doc("Jerk over the turn.")
    moves: list[MoveSummary] = doc("Every segment that moves.")


class FlankGeometry(AnswerModel):
    """One working curve of the cam, and the roller or face on it."""

    flank: str = doc("Name of the flank; empty where the cam has one.")
    largest_radius_mm: PeakValue = doc("Largest distance from the cam's axis.")
    smallest_radius_mm: PeakValue = doc("Smallest distance.")
    perimeter_mm: float = doc("Length of the curve.")
    area_mm2: float = doc("Area that it encloses.")
    centroid_mm: tuple[float, float] = doc("Centre of that area, in the cam's frame.")
    polar_moment_mm4: float = doc("Polar second moment of that area about the cam's axis.")
    convex_radius_mm: PeakValue | None = doc(
        "Least convex radius of curvature, not positive where undercut; null: nowhere convex."
    )
    hollow_radius_mm: PeakValue | None = doc("Least hollow radius; null: no hollow.")
    hollows: int = doc("Number of arcs on which it is hollow.")
    sliding_speed_mm_per_s: PeakValue | None = Field(
        None, description="Largest speed at which a flat face slides on the cam."
    )
    roller_speed_rpm: PeakValue | None = Field(
        None, description="Largest speed of the roller on its pin, rolling without slip."
    )
    roller_acceleration_rad_per_s2: PeakValue | None = Field(
        None, description="Its largest angular acceleration; between jumps."
    )


class MassProperties(AnswerModel):
    """The cam as a plate of the thickness and density in ``body``; without keyway and hub."""

    mass_kg: float = doc("Mass.")
    centre_of_gravity_mm: tuple[float, float] = doc("Centre of gravity, in the cam's frame.")
    moment_of_inertia_kg_m2: float = doc("Moment of inertia about the cam's axis.")


class CamGeometry(AnswerModel):
    """The cam as a body."""

    base_radius_mm: float = doc("Base radius.")
    prime_radius_mm: float = doc("Prime radius: of the traced point at the lowest position.")
    flanks: list[FlankGeometry] = doc("Its working curves.")
    mass_properties: MassProperties | None = Field(
        None, description="Of plates with `body` in the spec; of conjugate cams both together."
    )
