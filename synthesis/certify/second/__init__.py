"""The second judge: the certificate of a finished design measured again, in ball arithmetic.

In: a design as delivered (degrees, spline coefficients, size). Out: a ``Confirmation``, with every
line of the certificate to 25 digits and whether both judges agree. It derives everything from the
bare output link and shares neither enclosures nor formulas with ``certify``. It takes some tenths
of a second and needs python-flint, which the optional extra ``exact`` installs.

Open ``recertify.py`` first; ``claims.py`` measures the limits, ``invariants.py`` the other lines.
"""

from __future__ import annotations

from synthesis.certify.second.report import Confirmation
from synthesis.design.design import Design
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
    from synthesis.certify.second.recertify import recertify

    return recertify(design)
