"""What confirmation answers."""

from __future__ import annotations

from typing import Literal

from synthesis.catalogue.fields import AnswerModel, doc

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
