"""What an engineer would say of a spatial cam: rules of ``pipeline.advice`` on what was measured.

The values are the ``extremes`` of the answer. A rule is silent where the spec limits the same
quantity, and where the certificate refuses it already.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from synthesis.catalogue.forces.reduced import MILLI
from synthesis.design.warnings import Severity, worst
from synthesis.exporters.samples.cam import Turn
from synthesis.exporters.samples.sampling import in_degrees
from synthesis.machines.spatial.design import SpatialDesign, SpatialExtreme
from synthesis.pipeline.advice import jumps, pressure_angle, roller_speed, sharp_nose
from synthesis.pipeline.advice.rule import Finding, Rule, judge, number

ROLLER: Final = "machine/roller_radius_mm"


def with_warnings(design: SpatialDesign) -> SpatialDesign:
    """The same design with its warnings, and the severity of the worst."""
    found = judge(RULES, design) if design.motion else []
    return design.model_copy(update={"warnings": found, "severity": worst(found)})


def _measured(design: SpatialDesign, quantity: str) -> SpatialExtreme | None:
    """A quantity that is finite, keeps its bound and is not limited by the spec."""
    found = next((each for each in design.extremes if each.quantity == quantity), None)
    usable = found is not None and found.value is not None and found.holds and not found.field
    return found if usable else None


def _place(at: SpatialExtreme) -> str:
    """Where an extreme is, in words."""
    roller = f" on roller {at.roller}" if at.roller is not None else ""
    return f"at {number(at.angle_deg or 0.0)}°{roller}"


def _pressure_angle(design: SpatialDesign) -> Iterator[Finding]:
    found = _measured(design, "pressure_angle")
    if found is None or found.value is None:
        return
    machine = design.spec.machine
    swings, turret = machine.travel.unit == "deg", math.isfinite(machine.period)
    usual, most = pressure_angle.usual_angles(swings)
    if found.value <= (most if turret else usual):
        return
    jams = found.value > pressure_angle.JAM and not swings
    severity: Severity = "stop" if jams else "caution" if found.value > most else "note"
    kind = "a turret" if turret else "an arm" if swings else "a slide"
    most_of = number(most if turret else usual)
    yield Finding(
        severity, "limits/pressure_angle/max_deg",
        f"The pressure angle comes to {number(found.value)}° {_place(found)}; {most_of}° is "
        f"{'the most that is usual' if turret else 'usual'} for {kind}"
        + (": the slide would jam in its guide." if jams else "."),
        f"Ask for the limit pressure_angle with max_deg of {most_of}: the cam grows; or give the "
        "move more angle.",
    )  # fmt: skip


def _sharp_wall(design: SpatialDesign) -> Iterator[Finding]:
    undercut = next((each for each in design.extremes if each.quantity == "undercut"), None)
    if undercut is not None and not undercut.holds:
        return  # the certificate says it
    edge = sharp_nose.POINTED * design.dimensions["roller_radius_mm"]
    for quantity, limit, what in (
        ("convex_radius", "wall_radius", "A wall's radius"),
        ("rib_thickness", "rib_thickness", "The rib's thickness"),
    ):
        found = _measured(design, quantity)
        if found is not None and found.value is not None and found.value < edge:
            yield Finding(
                "stop", f"limits/{limit}/min_mm",
                f"{what} comes down to {number(found.value)} mm {_place(found)}: an edge, which "
                "carries no force.",
                f"Ask for the limit {limit} with min_mm of a few millimetres, take a smaller "
                "roller, or give the move more angle.",
            )  # fmt: skip


def _jumps(design: SpatialDesign) -> Iterator[Finding]:
    travel, omega = design.spec.machine.travel, design.spec.omega
    turn = Turn(design.curve, travel, omega)
    theta, order = turn.joints.theta, turn.joints.order
    left, right = (turn.motion.derivatives(theta, 2, side) for side in ("left", "right"))
    swept = design.cam.swept
    # how far the middle of a roller goes in a unit of the follower's position [mm]
    middle = (swept.origin + swept.roller.middle * swept.along)[:, None, None]
    lever = float(np.linalg.norm(swept.joint.velocity_per_q(middle)))
    found = []
    for k in (1, 2):
        sizes = np.where(order <= k, np.abs(right[k] - left[k]), 0.0) * lever * omega**k * MILLI
        at = int(np.argmax(sizes))
        angle = float(in_degrees(theta[at : at + 1])[0])
        segment = max(i for i, s in enumerate(design.motion) if s.start_deg <= angle + 1e-9)
        found.append(jumps.Jump(float(sizes[at]), angle, segment) if sizes[at] > 0.0 else None)
    velocity, acceleration = found
    yield from jumps.find_jumps(velocity, acceleration, otherwise="")


def _roller_speed(design: SpatialDesign) -> Iterator[Finding]:
    found = _measured(design, "roller_speed")
    if found is not None and found.value is not None:
        diameter = 2.0 * design.dimensions["roller_radius_mm"]
        yield from roller_speed.find_speed(diameter, abs(found.value), ROLLER)


RULES: Final[tuple[Rule[SpatialDesign], ...]] = (
    Rule(
        code="sharp_wall",
        thresholds="stop: a wall's least convex radius, or the thinnest place of a rib, below 1 % "
        "of the roller radius.",
        reason="An edge cannot carry a force, and wears at once.",
        source="As of sharp_nose: Cam Design Handbook (Rothbart, ed., 2004), section 6.4.2: a "
        "point is not acceptable because of its stress.",
        checked="The page of 6.4.2 opened, which speaks of plate cams. 1 % is this program's; of "
        "how thick a rib should be no source was found, so that nothing is said above it.",
        silenced_by="the limit wall_radius or rib_thickness (its own part)",
        find=_sharp_wall,
    ),
    Rule(
        code="jumps",
        thresholds="as of plane cams, of the middle of a roller.",
        reason=jumps.RULE.reason,
        source=jumps.RULE.source,
        checked=jumps.RULE.checked,
        silenced_by="nothing: the spec has no `continuity`",
        find=_jumps,
    ),
    Rule(
        code="pressure_angle",
        thresholds="note: above 30° on a slide, above 35° on an arm; caution: above 38°, above 50° "
        "on an arm or a turret; stop: above 70° on a slide.",
        reason=pressure_angle.RULE.reason,
        source=pressure_angle.RULE.source,
        checked="As of plane cams. Of turrets no source was found: they are taken for arms, "
        "without the note, since that of problem P4, which is printed, comes to 41°.",
        silenced_by="the limit pressure_angle",
        find=_pressure_angle,
    ),
    Rule(
        code="roller_speed",
        thresholds=roller_speed.RULE.thresholds,
        reason=roller_speed.RULE.reason,
        source=roller_speed.RULE.source,
        checked=roller_speed.RULE.checked,
        silenced_by=roller_speed.RULE.silenced_by,
        find=_roller_speed,
    ),
)
"""All rules of spatial cams; of two findings of one severity that of the earlier one comes first.

Shafts, springs and loads are not in the spec: nothing is said of them.
"""
