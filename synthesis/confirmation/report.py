"""What confirmation answers."""

from __future__ import annotations

from typing import Literal

from synthesis.design import Part, told

Verdict = Literal["confirmed", "contradicted", "incomplete"]


class Remeasured(Part):
    """One line of a certificate, measured a second time."""

    limit: str = told("The limit, as the certificate names it.")
    field: str = told("Field of the spec that sets its bound.")
    unit: str = told("Unit of the values.")
    value: str | None = told("What was found, to 25 digits; null: nothing finite, or not measured.")
    width: float | None = told("Width of its enclosure.")
    angle_deg: float | None = told("Cam angle where it was found.")
    certificate: float | None = told("What the certificate says.")
    difference: float | None = told("Value less what the certificate says.")
    holds: bool | None = told("Whether the bound is kept; null: not measured.")
    agrees: bool | None = told(
        "Whether the certificate's enclosure holds the value, and its verdict is right; null: "
        "not measured."
    )
    how: str = told("How it was measured, or why it was not.")


class Confirmation(Part):
    """A design's certificate in ball arithmetic."""

    id: str = told("Id of the design.")
    name: str = told("Name of the design.")
    verdict: Verdict = told(
        "confirmed: every line agrees; contradicted: a line does not; incomplete: the others "
        "agree, but a line could not be measured."
    )
    bits: int = told("Precision of the arithmetic.")
    lines: list[Remeasured] = told("Line by line, in the certificate's order.")
