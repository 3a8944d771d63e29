"""Whether a shaft and its hub fit into the base circle."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Final

from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

HUB_PER_SHAFT, HUB_MORE = 1.75, 6.35  # hub of cast iron: 1 3/4 shaft diameters + 1/4 in [mm]
SHEAR_MPA: Final = 40.0  # allowed in a shaft with a keyway: 6000 psi of the ASME code
THIN, THINNER = 0.2, 0.1  # shaft that the base circle leaves room for, over stroke


def _find(subject: Subject) -> Iterator[Finding]:
    if not subject.is_touched_from_outside:
        return
    radius, field = subject.base_radius, "base_radius_mm"
    shaft, known = _shaft(subject)
    hub = HUB_PER_SHAFT * shaft + HUB_MORE
    stroke = subject.stroke
    if radius <= 0.5 * shaft:
        yield Finding(
            "stop", field,
            f"The base radius of {number(radius)} mm lies inside the shaft of "
            f"{number(shaft)} mm diameter{known}.",
            f"Ask for a base radius of at least {number(0.5 * hub)} mm.",
        )  # fmt: skip
    elif subject.base_radius_is_set:
        return
    elif shaft > 0.0 and radius < 0.5 * hub:
        yield Finding(
            "caution", field,
            f"A shaft of {number(shaft)} mm diameter{known} asks for a hub of {number(hub)} mm "
            f"in cast iron; the base circle has {number(2.0 * radius)} mm.",
            f"Ask for a base radius of at least {number(0.5 * hub)} mm (in steel slightly "
            "less), or make cam and shaft in one piece.",
        )  # fmt: skip
    elif (room := max((2.0 * radius - HUB_MORE) / HUB_PER_SHAFT, 0.0)) < THIN * stroke:
        shaft_left = f"a shaft of {number(room)} mm diameter" if room > 0.0 else "no shaft"
        yield Finding(
            "stop" if room < THINNER * stroke else "caution", field,
            f"The base radius of {number(radius)} mm leaves room for {shaft_left}, against a "
            f"stroke of {number(stroke)} mm.",
            "Ask for a base radius that suits the shaft: at least 0.875 shaft diameters plus "
            '3.2 mm, as base_radius_mm {"min": …}.',
        )  # fmt: skip


def _shaft(subject: Subject) -> tuple[float, str]:
    """Diameter of the shaft [mm], and how it is known; 0 where nothing says it."""
    forces = subject.design.forces
    peaks = () if forces is None else (forces.torque.largest_n_m, forces.torque.smallest_n_m)
    torque = max((abs(peak.value) for peak in peaks if peak is not None), default=0.0)
    if torque <= 0.0:
        return 0.0, ""
    # τ = 16 T/(π d³), T in N mm
    diameter = (16.0 * 1e3 * torque / (pi * SHEAR_MPA)) ** (1.0 / 3.0)
    return diameter, f" (which the largest torque of {number(torque)} N m needs)"


RULE = Rule(
    code="hub",
    thresholds="stop: the base circle inside the shaft; caution: a base circle below the hub's "
    "1.75 shaft diameters plus 1/4 in. A shaft that is not given is the thinnest that carries the "
    "largest torque at 40 N/mm². And by itself: caution where the shaft for which this rule leaves "
    "room is thinner than a fifth of the stroke, stop: than a tenth.",
    reason="The cam has to be fixed on a shaft, and a key needs material round it.",
    source="Cam Design Handbook (Rothbart, ed., 2004), section 6.4.4, eq. 6.21: hub of cast iron, "
    "of steel slightly less; ASME code for transmission shafting: 6000 psi with a keyway.",
    checked="The page of 6.4.4 opened; the code's text not. A fifth and a tenth of the "
    "stroke are this program's, for want of a rule.",
    silenced_by="a base radius that is given, or has a least value (all but the base circle inside "
    "the shaft)",
    find=_find,
)
