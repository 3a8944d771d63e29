"""What a caller may choose about the files that hold a curve itself instead of its points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from synthesis.exporters.options import PlacedCurve

MIN_ERROR_UM = 1e-6
ARCS_UM = 1.0  # tolerance of arcs where none is asked for

Bore = Annotated[
    float | None, Field(gt=0.0, le=1e6, description="Diameter of the bore around the cam's axis.")
]


@dataclass(frozen=True, kw_only=True)
class ExactOptions(PlacedCurve):
    """Which curve, and how near to the true one.

    Attributes:
        tolerance_um: largest distance from the true curve, along its normal [µm].
        the rest as of ``PlacedCurve``.
    """

    tolerance_um: Annotated[
        float,
        Field(
            ge=MIN_ERROR_UM,
            le=1e3,
            description="Largest distance of the spline from the true curve, along its normal "
            "[µm]. What is reached is told in the header Camwright-Curve-Error-Mm.",
        ),
    ] = 1e-3

    @property
    def tolerance_mm(self) -> float:
        """The tolerance [mm]."""
        return 1e-3 * self.tolerance_um


@dataclass(frozen=True, kw_only=True)
class DrawingOptions(PlacedCurve):
    """What a drawing for CAD and CAM shows.

    Attributes:
        form: how the curves are drawn. tolerance_um: how near; None: as the form is used.
        companions: whether more is drawn than the curve asked for.
        bore_mm: diameter of the bore. the rest as of ``PlacedCurve``.
    """

    form: Annotated[
        Literal["spline", "arcs"],
        Field(
            description="One SPLINE of degree 5 a curve, for CAD; or a polyline of arcs that meet "
            "without a corner, for controls and saws that know no spline."
        ),
    ] = "spline"
    tolerance_um: Annotated[
        float | None,
        Field(
            ge=MIN_ERROR_UM,
            le=1e3,
            description="Largest distance from the true curve, along its normal [µm]. Left out: "
            "0.001 for splines, 1 for arcs. What is reached is told in the header "
            "Camwright-Curve-Error-Mm.",
        ),
    ] = None
    companions: Annotated[
        bool,
        Field(
            description="Draw all of the cam, each kind on its own layer: every flank, rollers' "
            "paths, base circle, bore. Otherwise the one curve alone."
        ),
    ] = True
    bore_mm: Bore = None

    @property
    def tolerance_mm(self) -> float:
        """The tolerance [mm]."""
        usual = ARCS_UM if self.form == "arcs" else 1e-3
        return 1e-3 * (usual if self.tolerance_um is None else self.tolerance_um)
