"""What a rule of advice is: where it comes from, what silences it, and what it finds on a cam."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from synthesis.catalogue.forces.load import GRAVITY
from synthesis.design.warnings import SEVERITIES, DesignWarning, Severity

Judged = TypeVar("Judged")  # what rules look at: a ``Subject``, or the answer of a machine
SMALL_ACCELERATION = 0.1 * GRAVITY  # m/s²: its force on a mass is a tenth of the weight


class Finding(NamedTuple):
    """What a rule finds: how severe, where in the spec it is mended, what is wrong, the remedy."""

    severity: Severity
    field: str
    sentence: str
    remedy: str


@dataclass(frozen=True)
class Rule(Generic[Judged]):
    """One rule of the field.

    Attributes:
        code: its name on the wire.
        thresholds: from which values on it warns, by severity. reason: why.
        source: where it is from. checked: what of the source was opened, and what is our own.
        silenced_by: what of the spec says that the value is meant.
        find: what it finds. Of a spec whose answer has no cam ``Subject.has_cam`` is false; only
            rules with ``without_cam`` are asked then.
    """

    code: str
    thresholds: str
    reason: str
    source: str
    checked: str
    silenced_by: str
    find: Callable[[Judged], Iterable[Finding]]
    without_cam: bool = False


def number(value: float) -> str:
    """A value in a sentence: three digits, no exponent; below a thousandth it is called so."""
    if 0.0 < abs(value) < 1e-3:
        return "less than 0.001"
    return f"{value:.3g}" if abs(value) < 1e3 else f"{value:,.0f}".replace(",", "\u202f")


def judge(rules: Iterable[Rule[Judged]], subject: Judged) -> list[DesignWarning]:
    """What rules find, the most severe first; of one severity that of the earlier rule."""
    found = [
        DesignWarning(
            code=rule.code, severity=severity, field=field, sentence=sentence, remedy=remedy,
            source=rule.source,
        )
        for rule in rules
        for severity, field, sentence, remedy in rule.find(subject)
    ]  # fmt: skip
    return sorted(found, key=lambda one: -SEVERITIES.index(one.severity))
