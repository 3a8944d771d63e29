"""A sweep where curvature decides: what neighbouring designs could hand each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import median, quantiles
from time import process_time

import casadi
import numpy as np

from benchmarks.effort import FULL, Effort
from benchmarks.proof import SCENES
from benchmarks.section import Section, Table
from benchmarks.timing import spread
from synthesis.design import Design
from synthesis.formulations.candidate import grow, mended, settle
from synthesis.formulations.convex import Plan
from synthesis.formulations.nonlinear import NonlinearSolution, exchanged, improve
from synthesis.formulations.statement import Statement
from synthesis.pipeline import synthesise
from synthesis.sensitivity.family import Family
from synthesis.solvers.ipopt import OPTIONS
from synthesis.spec import DesignSpec

RADII = tuple(float(r) for r in np.linspace(9.0, 15.0, 10))
ANGLES = tuple(float(a) for a in np.linspace(26.0, 35.5, 20))
SPARE, ACCURACY = 2e-4, 5e-8  # what a design at this tolerance asks of IPOPT
TEXT = """The main job with a profile radius, 200 designs over radius and pressure angle of the
rise, in the order of a grid, processor time of one core. *Warm* is IPOPT from the point and
multipliers of the design before, on its knots, in place of the whole nonlinear stage; cone
programs, bound and certificate stay. *Stated and built* is what one program for IPOPT takes before
it is solved: the most that functions built once and kept could save."""


@dataclass(frozen=True, eq=False)
class Step:
    """A design and what its neighbour would have made of it.

    Attributes:
        seconds: of the design. nonlinear: of its nonlinear stage. warm: of that from the design
            before. building: of one program for IPOPT. apart: value of the warm cam over the
            design's, less 1.
    """

    spec: DesignSpec
    design: Design
    seconds: float
    nonlinear: float
    building: float
    warm: float = 0.0
    apart: float = 0.0


def questions(effort: Effort) -> Iterator[DesignSpec]:
    """The sweep's."""
    for radius in effort.some(RADII):
        for angle in effort.some(ANGLES, 3):
            yield replace(SCENES[0], radius=radius, angles=(angle, 45.0)).spec()


def steps(effort: Effort) -> Iterator[Step]:
    """One design after the other."""
    before: tuple[Family, NonlinearSolution] | None = None
    for spec in questions(effort):
        began = process_time()
        design = synthesise(spec)
        seconds = process_time() - began
        family = Family.of(design, spec)
        plan, _ = family.stated(family.posed(spec))
        stages = [stage.seconds for stage in design.report.stages if stage.stage == "nonlinear"]
        share = sum(stages) / design.report.seconds
        step = Step(spec, design, seconds, share * seconds, _building(plan, family))
        yield step if before is None else _warm(step, *before)
        before = family, improve(plan, family.start(plan), None, SPARE, ACCURACY)


def _building(plan: Plan, family: Family) -> float:
    """Seconds to state a program for IPOPT and to build its derivatives."""
    from synthesis.formulations.nonlinear import settled
    from synthesis.formulations.spots import spread as spots

    start = family.start(plan)
    places = spots(*settled(plan, start))
    began = process_time()
    program = Statement(plan, start).stated(places, SPARE)
    stated = {"x": program.x, "f": program.objective, "g": program.rows}
    casadi.nlpsol("built", "ipopt", stated, OPTIONS)
    return process_time() - began


def _warm(step: Step, family: Family, known: NonlinearSolution) -> Step:
    """The same from the design before."""
    began = process_time()
    plan, _ = family.stated(family.posed(step.spec))
    found = exchanged(plan, known.spots, known.guess, None, SPARE, ACCURACY)
    cam = grow(mended(settle(plan.problem, *plan.recover(found.x), keep_hint=True)))
    warm = process_time() - began
    assert cam is not None
    assert step.design.certificate.value is not None
    value = plan.problem.objective.to_wire(cam.value, plan.problem.machine)
    return replace(step, warm=warm, apart=value / step.design.certificate.value - 1.0)


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
    later = found[1:]
    knots = {
        tuple(tuple(s.spline.knots) for s in step.design.motion if s.spline is not None)
        for step in found
    }
    cold = median(step.seconds for step in later)
    with_warm = [step.seconds - step.nonlinear + step.warm for step in later]
    rows = [
        ("a design", _told([step.seconds for step in later]), ""),
        ("its nonlinear stage", _told([step.nonlinear for step in later]), ""),
        ("that, warm", _told([step.warm for step in later]), ""),
        ("a design, warm", _told(with_warm), _share(1.0 - median(with_warm) / cold)),
        (
            "stated and built",
            _told([step.building for step in later]),
            _share(median(step.building for step in later) / cold),
        ),
    ]
    worst = max(abs(step.apart) for step in later)
    return Section(
        "What neighbours could hand each other",
        TEXT,
        [
            Table(
                ("", ">time", ">saves at most"), rows,
                f"{len(found)} designs on {len(knots)} sets of knots; warm cams differ by up to "
                f"{worst:.1e} of the base radius; looser neighbours' lower bounds say more of "
                f"{raised(found)} designs.",
            )
        ],
    )  # fmt: skip


def _told(seconds: Sequence[float]) -> str:
    low, _, high = quantiles(seconds, n=4, method="inclusive")
    return spread(median(seconds), low, high)


def _share(part: float) -> str:
    return f"{100.0 * part:.0f} %"
