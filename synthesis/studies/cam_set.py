"""synthesise_set(spec) -> CamSet: each cam by the ordinary pipeline, then mounted on the shaft."""

from __future__ import annotations

import time

from synthesis.design.cam_set import CamSet, assemble_set, mount, timing_of
from synthesis.design.design import Design
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.numerics import clock
from synthesis.pipeline.synthesise import synthesise
from synthesis.spec.cam_set import CamSetSpec


def synthesise_set(spec: CamSetSpec, *, deadline: float | None = None) -> CamSet:
    """Design every cam of a set.

    The cams are independent: a phase only rotates a cam on the shaft. Each cam gets its share of
    the time that is left until ``deadline``, a ``time.monotonic()``, or within the spec's own
    budget. The set's status is the worst of its cams'.

    Raises:
        TimeBudgetExceeded: time ran out; carries the set with the best of every cam, if each has
            one.
        SolverFailed: as for a single cam.
    """
    began, budget = time.perf_counter(), clock.seconds_left(spec.time_budget_s, deadline)
    stop = clock.now() + budget
    designs: list[Design] = []
    late = False
    for position, cam in enumerate(spec.cams):
        now = clock.now()
        try:
            share = now + (stop - now) / (len(spec.cams) - position)
            designs.append(synthesise(cam.spec, deadline=share))
        except TimeBudgetExceeded as error:
            if error.best is None:
                raise TimeBudgetExceeded(error.budget_s) from None
            late = True
            designs.append(error.best)
        except SolverFailed as error:
            advice = f"This was the cam at /cams/{position}. {error.advice}"
            raise SolverFailed(error.solver, error.status, advice) from None
    pairs = zip(spec.cams, designs, strict=True)
    cams = [mount(i, cam, design) for i, (cam, design) in enumerate(pairs)]
    result = assemble_set(spec, cams, timing_of(cams), time.perf_counter() - began)
    if late:
        raise TimeBudgetExceeded(budget, result)
    return result
