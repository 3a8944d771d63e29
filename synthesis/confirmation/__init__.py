"""A second judge, to the last digit: a finished design's certificate in ball arithmetic.

It takes what is on the wire (degrees, spline coefficients, size) and the follower's bare mechanism,
and derives everything else by itself; it shares neither enclosures nor formulas with ``certify``.
Slow beside it, some tenths of a second, and optional: the extra ``exact`` brings python-flint.
"""

from __future__ import annotations

from synthesis.confirmation.report import Confirmation
from synthesis.design import Design
from synthesis.errors import ExtraMissing

__all__ = ["Confirmation", "confirm"]
EXTRA = "exact"


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
    from synthesis.confirmation.design import confirmed

    return confirmed(design)
