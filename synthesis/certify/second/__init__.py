"""The second judge: the certificate of a finished design measured again, in ball arithmetic.

In: a design as delivered (degrees, spline coefficients, size). Out: a ``Confirmation``, with every
line of the certificate to 25 digits and whether both judges agree. It starts from the bare output
link at rest and shares neither enclosures nor other formulas with ``certify``; dimensions besides
base radius and centre distance are taken as the design states them. It takes some tenths of a
second and needs python-flint, which the optional extra ``exact`` installs.

Open ``recertify.py`` first; ``claims.py`` measures the limits, ``invariants.py`` the other lines.
"""

from __future__ import annotations

from typing import Literal

from synthesis.catalogue.fields import AnswerModel, doc
from synthesis.design.design import Design
from synthesis.errors import ExtraMissing

__all__ = ["Confirmation", "Remeasured", "Verdict", "confirm"]
EXTRA = "exact"
Verdict = Literal["confirmed", "contradicted", "incomplete"]


class Remeasured(AnswerModel):
    """One line of a certificate, measured a second time."""

    limit: str = doc("The limit, as the certificate names it.")
    field: str = doc("Field of the spec that sets its bound.")
    unit: str = doc("Unit of the values.")
    value: str | None = doc("What was found, to 25 digits; null: nothing finite, or not measured.")
    width: float | None = doc("Width of its enclosure.")
    angle_deg: float | None = doc("Cam angle where it was found.")
    certificate: float | None = doc("What the certificate says.")
    difference: float | None = doc("Value less what the certificate says.")
    holds: bool | None = doc("Whether the bound is kept; null: not measured.")
    agrees: bool | None = doc(
        "Whether the certificate's enclosure holds the value, and its verdict is right; null: "
        "not measured."
    )
    how: str = doc("How it was measured, or why it was not.")


class Confirmation(AnswerModel):
    """A design's certificate in ball arithmetic."""

    id: str = doc("Id of the design.")
    name: str = doc("Name of the design.")
    verdict: Verdict = doc(
        "confirmed: every line agrees; contradicted: a line does not; incomplete: the others "
        "agree, but a line could not be measured."
    )
    bits: int = doc("Precision of the arithmetic.")
    lines: list[Remeasured] = doc("Line by line, in the certificate's order.")


def confirm(design: Design) -> Confirmation:
    """Measure every line of a design's certificate again, to 25 digits.

    Raises:
        InputError: the design has no cam.
        ExtraMissing: python-flint is not installed.
    """
    try:
        import flint  # noqa: F401
    except ImportError as error:
        raise ExtraMissing("Confirming a design", EXTRA) from error
    from synthesis.certify.second.recertify import recertify

    return recertify(design)
