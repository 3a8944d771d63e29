"""The forms of every limit agree: what the optimiser keeps is what the certificate measures.

The two are written independently on purpose, so that an error in one cannot confirm the other. Here
random cams decide, with bounds 1 % to both sides of the extremes that the certificate measures on
them: where the claims of a limit hold, so do its rows, norms and nonconvex constraints; where one
is broken, while everything else holds, at least one form is broken too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec
from synthesis.catalogue.constraints import Vector
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import Motion
from synthesis.certify.certificate import certify
from synthesis.design.design import Extreme
from synthesis.optimise.problem.residual_vibration import amplitude
from tests.catalogue import scenes
from tests.certify.cams import spline
from tests.hard.families import FAMILIES, random_scene

TRIES = 200  # of a cam that can be made
STEP = 0.01  # relative: how far a bound lies from the extreme
ROUNDING = 1e-9  # of the sum of the absolute terms
DENSE = np.linspace(0.0, 1.0, 601)
LEFT_OUT = {"free", "class", "window"}  # free numbers, smoother splines, limits of one segment
SCENES = [*scenes.LIMITS, *(n for n in FAMILIES if LEFT_OUT.isdisjoint(n.split()))]


@dataclass(frozen=True, eq=False)
class Cam:
    """A cam that nobody optimised, of the program and follower of a scene."""

    motion: Motion
    machine: Machine
    size: Vector

    def lines(self, *limits: Limit) -> list[Extreme]:
        return certify(self.motion, self.machine, self.size, limits)

    def excesses(self, limit: Limit) -> Iterator[float]:
        """Left less right side of every form that the optimiser uses, as shares of their terms."""
        size = np.array(self.size)
        for segment in self.motion.segments:
            if segment.angle == 0.0:
                continue
            theta = segment.start + segment.angle * DENSE
            s = segment.placed().derivatives(theta, 3, "right")
            s[:, -1:] = segment.placed().derivatives(theta[-1:], 3, "left")
            for row in limit.rows(segment, self.machine):
                shares = np.array(row.coefficients)[:, None] * s
                still = size * row.size if row.size else np.zeros(1)
                terms = np.abs(shares).sum(axis=0) + np.abs(still).sum() + abs(row.upper)
                yield np.max((shares.sum(axis=0) + still.sum() - row.upper) / (terms + 1e-300))
            for value in limit.smooth_constraints(
                segment, self.machine, theta, tuple(s), self.size
            ):
                yield float(np.max(value))
        for bounds in limit.norm_bounds(self.motion.segments, self.machine):
            value = bounds.norm.value(self.size)
            yield (value - bounds.upper) / (value + abs(bounds.upper))
            yield (bounds.lower - value) / (value + abs(bounds.upper))
        for each in limit.vibration_bounds(self.motion.segments, self.machine):
            yield amplitude(each, self.motion.segments) - each.max_amplitude


def with_given_counter(follower: Follower, stroke: float) -> Follower:
    """A place for the counter roller, where the follower has one."""
    field = getattr(follower.closure, "field", "")
    if not field:
        return follower
    place = {"angle_deg": 77.7, "distance_mm": 7.7 * stroke}[field]
    return follower.with_closure(follower.closure.model_copy(update={field: place}))


def random_cams(spec: DesignSpec) -> Iterator[Cam]:
    """Splines in place of free laws, and sizes of half to five strokes; unfit ones left out."""
    random = np.random.default_rng(20_261_123)
    machine, segments, stroke = spec.machine(), spec.placed_segments(), spec.stroke()
    machine = replace(machine, follower=with_given_counter(machine.follower, stroke))
    domain = machine.follower.size_domain((0.5 * stroke, 5.0 * stroke))
    for _ in range(TRIES):
        laws = []
        for segment in segments:
            if segment.law_is_free:
                breaks = np.array([0.0, *np.sort(random.uniform(0.15, 0.85, 3)), 1.0])
                bumps = random.uniform(-0.02, 0.02, len(breaks) + 4)
                segment = segment.with_law(spline(5, breaks, bumps))
            laws.append(segment)
        size = tuple(float(random.uniform(*ends)) for ends in domain.bounds)
        cam = Cam(Motion.of(laws), machine, size)
        if all(line.holds for line in cam.lines()):
            yield cam


def lines_by_field(cam: Cam, limit: Limit) -> dict[str, list[Extreme]]:
    """What the certificate says of each field of a limit."""
    found: dict[str, list[Extreme]] = {}
    for line in cam.lines(limit):
        kind, _, field = line.field.partition("/")
        if kind == limit.kind:
            found.setdefault(field, []).append(line)
    return found


def loose_and_tight(cam: Cam, limit: Limit) -> Iterator[tuple[Limit, Limit]]:
    """For each field a limit that the cam keeps and one that it breaks, in this field alone."""
    ends = dict[str, tuple[float, float]]()
    for field, lines in lines_by_field(cam, limit).items():
        values = [abs(line.value) for line in lines if line.value is not None]
        if not values or max(values) == 0.0:
            continue
        low, high = min(values) * (1 - STEP), max(values) * (1 + STEP)
        changed = (limit.model_copy(update={field: value}) for value in (low, high))
        below, above = (
            all(line.holds for line in lines_by_field(cam, one)[field]) for one in changed
        )
        if below != above:
            ends[field] = (low, high) if below else (high, low)
    loose = limit.model_copy(update={field: value for field, (value, _) in ends.items()})
    if all(line.holds for lines in lines_by_field(cam, loose).values() for line in lines):
        for field, (_, value) in ends.items():
            yield loose, loose.model_copy(update={field: value})


@pytest.mark.parametrize("name", SCENES)
def test_forms_and_claims_agree(name: str):
    body: Any = scenes.LIMITS[name] if name in scenes.LIMITS else random_scene(name, 3)
    spec = DesignSpec.model_validate(body)
    for cam in random_cams(spec):
        compared = 0
        for limit in spec.limits:
            for loose, tight in loose_and_tight(cam, limit):
                assert max(cam.excesses(loose)) <= ROUNDING, loose
                assert max(cam.excesses(tight)) > 0.0, tight
                compared += 1
        if compared >= len(spec.limits):
            return
    pytest.fail("no cam was found with which every limit can be kept and broken")
