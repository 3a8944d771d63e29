"""Warnings of a cam: what an engineer of the field would say of it before it is built."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

from synthesis.catalogue.fields import AnswerModel, doc

Severity = Literal["none", "note", "caution", "stop"]
SEVERITIES: Final[tuple[Severity, ...]] = ("none", "note", "caution", "stop")
"""In order: note, unusual; caution, few would build it; stop, it cannot work."""


class DesignWarning(AnswerModel):
    """What an engineer would say of the cam, and what to change."""

    code: str = doc("The rule; the page `warnings` of the documentation lists all.")
    severity: Severity = doc("note: unusual; caution: few would build it; stop: it cannot work.")
    field: str = doc("Where in the spec it is mended.")
    sentence: str = doc("What is wrong, with the values.")
    remedy: str = doc("What to change.")
    source: str = doc("Where the rule is from.")


def worst(warnings: Sequence[DesignWarning]) -> Severity:
    """The severity of the most severe warning."""
    return max((one.severity for one in warnings), key=SEVERITIES.index, default="none")


def labelled_status(status: str, severity: Severity) -> str:
    """A status as it is shown: never without the word ``stop`` where there is one."""
    if severity != "stop":
        return status
    return f"{status}, {'but' if status in ('optimal', 'feasible') else 'and'} STOP"
