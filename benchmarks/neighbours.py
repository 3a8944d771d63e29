"""A sweep where curvature decides: what neighbouring designs hand each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import median, quantiles
from time import process_time

import numpy as np

from benchmarks.effort import FULL, Effort
from benchmarks.proof import SCENES
from benchmarks.section import Section, Table
from benchmarks.timing import spread
from service.sweeps.chunks import CHAIN
from synthesis.design.design import Design
from synthesis.pipeline.synthesise import Neighbour, synthesise
from synthesis.spec.design_spec import DesignSpec

RADII = tuple(float(r) for r in np.linspace(9.0, 15.0, 10))
ANGLES = tuple(float(a) for a in np.linspace(26.0, 35.5, 20))
TEXT = """The main job with a profile radius, 200 designs over radius and pressure angle of the
rise, in the order of a grid, processor time of one core. *Warm*: a sweep's warm starts, chains of
eight, the local search begun where the design before has ended; cone programs, bound and
certificate stay."""
LOCAL = ("tangents", "nonlinear")


@dataclass(frozen=True, eq=False)
class Step:
    """A design and what its neighbour would have made of it.

    Attributes:
        seconds: of the design. local: of its local search. warm: of the design in its chain.
        apart: value of the warm cam over the design's, less 1. begun: whether it was begun at the
            one before.
    """

    spec: DesignSpec
    design: Design
    seconds: float
    local: float
    warm: float
    apart: float
    begun: bool


def questions(effort: Effort) -> Iterator[DesignSpec]:
    """The sweep's."""
    for radius in effort.some(RADII):
        for angle in effort.some(ANGLES, 3):
            yield replace(SCENES[0], radius=radius, angles=(angle, 45.0)).spec()


def steps(effort: Effort) -> Iterator[Step]:
    """One design after the other, alone and in its chain."""
    neighbours: list[Neighbour] = []
    for number, spec in enumerate(questions(effort)):
        began = process_time()
        design = synthesise(spec)
        alone = process_time()
        if number % CHAIN == 0:
            neighbours = []
        warm = synthesise(spec, neighbours=neighbours)
        both = process_time()
        stages = [stage.seconds for stage in design.report.stages if stage.stage in LOCAL]
        share = sum(stages) / design.report.seconds
        value, other = design.certificate.value, warm.certificate.value
        assert value is not None
        assert other is not None
        yield Step(
            spec, design, alone - began, share * (alone - began), both - alone,
            other / value - 1.0, warm.started_from is not None,
        )  # fmt: skip


def raised(found: Sequence[Step]) -> int:
    """How many designs a looser neighbour's lower bound would tell more of."""
    bounds = []
    for step in found:
        angle, _, radius = (limit.model_dump() for limit in step.spec.limits)
        bounds.append((angle["rise_deg"], radius["min_mm"], step.design.certificate.lower_bound))
    return sum(
        any(a >= angle and r <= radius and other > bound * (1.0 + 1e-6) for a, r, other in bounds)
        for angle, radius, bound in bounds
    )


def run(effort: Effort = FULL) -> Section:
    """The whole sweep."""
    found = list(steps(effort))
    mean = sum(step.seconds for step in found)
    rows = [
        ("a design", _describe([step.seconds for step in found]), ""),
        ("its local search", _describe([step.local for step in found]), ""),
        (
            "a design in its chain",
            _describe([step.warm for step in found]),
            _share(1.0 - sum(step.warm for step in found) / mean),
        ),
    ]
    worst = max(abs(step.apart) for step in found)
    begun = sum(step.begun for step in found)
    return Section(
        "What neighbours hand each other",
        TEXT,
        [
            Table(
                ("", ">time", ">saves"), rows,
                f"{len(found)} designs, {begun} of them begun at the one before; their cams differ "
                f"by up to {worst:.1e} of the base radius from those of the specs alone; looser "
                f"neighbours' lower bounds say more of {raised(found)} designs.",
            )
        ],
    )  # fmt: skip


def _describe(seconds: Sequence[float]) -> str:
    low, _, high = quantiles(seconds, n=4, method="inclusive")
    return spread(median(seconds), low, high)


def _share(part: float) -> str:
    return f"{100.0 * part:.0f} %"
