"""How sharply the pitch curve bends against the roller, and a face's cam by itself."""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose
from typing import Final

from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

POINTED: Final = 0.01  # of the roller radius, under a face of the base radius: a point, no surface
SHARP: Final = 1.25  # pitch radius over roller radius: the profile's is a quarter of the roller's
SAME: Final = 1e-6  # relative: the base circle's radius, but for rounding
ADVISED: Final = 2.0  # pitch radius over roller radius: the lower end of the field's 2 to 3


def _find(subject: Subject) -> Iterator[Finding]:
    # A least radius, or a largest pressure, is the user's own judgement of the nose.
    asked = any(getattr(each, "min_mm", 0.0) > 0.0 for each in subject.limits("profile_radius"))
    if asked or subject.limited("hertz_pressure"):
        return
    for flank in subject.spec.follower.flanks:
        line = subject.extreme("profile_radius", flank.name)
        if line is None or line.value is None or not line.holds:
            continue  # nowhere convex, or undercut, which the certificate says
        radius, roller = line.value, flank.distance
        where = f"at {number(line.angle_deg)}°" + (f" on the {flank.name} flank" * bool(flank.name))
        wanted = number(roller) if roller > 0.0 else "a few"
        remedy = f"Ask for the limit profile_radius with min_mm of {wanted} mm or so" + (
            ", or take a smaller roller." if roller > 0.0 else "."
        )
        field = "limits/profile_radius/min_mm"
        if radius < POINTED * (roller or subject.base_radius):
            yield Finding(
                "stop", field,
                f"The profile runs to a point {where}: its radius is {number(radius)} mm"
                + (f" under a roller of {number(roller)} mm." if roller > 0.0 else "."),
                remedy,
            )  # fmt: skip
        elif radius < (ADVISED - 1.0) * roller and not _is_circle(radius, subject):
            sharp = radius < (SHARP - 1.0) * roller
            yield Finding(
                "caution" if sharp else "note", field,
                f"The pitch curve bends {where} with {number(radius + roller)} mm, "
                f"{number((radius + roller) / roller)} times the roller radius: the profile's "
                f"radius there is {number(radius)} mm.",
                remedy,
            )  # fmt: skip


def _is_circle(radius: float, subject: Subject) -> bool:
    """Whether it is the base circle that has this radius: then the rule hub judges it."""
    return isclose(radius, subject.base_radius, rel_tol=SAME)


RULE = Rule(
    code="sharp_nose",
    thresholds="stop: the profile's least convex radius below 1 % of the roller radius (under a "
    "flat face, of the base radius); caution: the pitch curve's below 1.25 roller radii; note: "
    "below 2.",
    reason="Where the pitch radius comes down to the roller's, the profile is a point: it cannot "
    "carry a force, and wears at once. The rule of the field is a pitch radius of at least 2 to 3 "
    "roller radii.",
    source="Cam Design Handbook (Rothbart, ed., 2004), section 6.4.2: a point is not acceptable "
    "because of its stress; university lectures: the least radius of the pitch curve 2 to 3 "
    "roller radii.",
    checked="The page of 6.4.2 opened, and two lectures with 2 to 3, which seem to follow Norton; "
    "a course in Chinese asks for a convex profile of 3 to 5 mm instead. 1.25 and 1 % are this "
    "program's.",
    silenced_by="the limit profile_radius with min_mm above 0, or the limit hertz_pressure",
    find=_find,
)
