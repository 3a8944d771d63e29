"""Proven radii of walls: that none is smaller is a claim about rollers of other radii.

With κ1 ≥ 0 ≥ κ2 the curvatures of the surface that the roller's axis sweeps (a ruled one has no
others), a wall bulges with the radius 1/κ1 − Rr and is hollow with 1/|κ2| + Rr. That no wall bulges
more sharply than r is that a roller of R = Rr + r would not undercut it; that none is hollow more
sharply, that one of R = Rr − r would not, a roller of negative radius being one on the other side:
(1 − R κ1)(1 − R κ2) > 0 everywhere. No root is in that, and so none of nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace

from synthesis.spatial.measuring.enclosing import EVIDENCE, Models, Proof, largest, undercut
from synthesis.spatial.measuring.found import Found

SHY = 1e-6, 1e-4, 1e-2  # of a radius: by how much less is claimed than was found, in turn
NEAR = 0.9  # of what a bound leaves over: a claim so far does


def bulging(models: Models, found: Found, allowed: float | None) -> Found:
    """What was found of the least convex radius, with a proof that none is smaller."""
    return _claimed(models, found, allowed, 1.0)


def hollow(models: Models, found: Found, allowed: float | None) -> Found:
    """The same of the least hollow radius."""
    return _claimed(models, found, allowed, -1.0)


def _claimed(models: Models, found: Found, allowed: float | None, sign: float) -> Found:
    """With found and allowed as curvatures with their signs turned [1/mm]; as it was if open."""
    if found.value >= 0.0:
        return found
    radius, roller = -1.0 / found.value, models.cam.swept.roller.radius
    least = -math.inf if allowed is None else radius - NEAR * (radius + 1.0 / allowed)
    for claim in (max(radius * (1.0 - shy), min(least, radius)) for shy in SHY):
        proof = Proof(undercut(roller + sign * claim), -1.0)
        if largest(models, proof, 0.0) <= 0.0:
            return replace(found, limit=-1.0 / claim, evidence=EVIDENCE)
    return found
