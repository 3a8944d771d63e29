"""analyse(spec) -> Analysis: what a cam does that is given in full.

Nothing is chosen here. The certificate judges the cam, the judge's own enclosures sum up its
curves, and where a limit is broken the ordinary synthesis says which size would mend it.
"""

from __future__ import annotations

from math import inf
from typing import Literal

from synthesis import clock
from synthesis.answer import Cam, design, dimensions, judged
from synthesis.certify import forces
from synthesis.certify.curves import Curves
from synthesis.design import Conflict, Design, engine_version
from synthesis.errors import InputError, SolverFailed, TimeBudgetExceeded
from synthesis.findings import Analysis, Mend, SizeChange
from synthesis.formulations.free_numbers.tables import smooth_tables
from synthesis.objectives.base_radius import BaseRadius
from synthesis.pipeline import synthesise
from synthesis.spec import DesignSpec

Offset = Literal["kept", "free"]


def analyse(spec: DesignSpec, *, deadline: float | None = None) -> Analysis:
    """Say what a given cam does, which limits it breaks, by how much, where, and what mends it.

    ``deadline`` is a ``time.monotonic()``; the spec's own budget counts as well.

    Raises:
        InputError: something is left free.
        TimeBudgetExceeded: time ran out while looking for what would mend it.
    """
    cam = given(spec)
    extremes = judged(spec, cam)
    broken = [extreme.limit for extreme in extremes if not extreme.holds]
    curves = Curves(cam.motion, spec.machine(), cam.size)
    return Analysis(
        name=spec.name,
        engine_version=engine_version(),
        holds=not broken,
        dimensions=dimensions(spec, cam),
        broken=broken,
        extremes=extremes,
        curves=curves.summaries(),
        jumps=curves.jumps(),
        undercut=curves.undercut(),
        self_crossing=curves.self_crossing(),
        forces=forces(cam.motion, spec.machine(), cam.size),
        mend=mend(spec, cam, _stop(spec, deadline)) if broken else None,
        spec=spec,
    )


def _stop(spec: DesignSpec, deadline: float | None) -> float:
    """The earlier of the caller's deadline and the end of the spec's own budget, from now on."""
    own = inf if spec.time_budget_s is None else clock.now() + spec.time_budget_s
    return min(own, inf if deadline is None else deadline)


def as_design(found: Analysis) -> Design:
    """The cam of an analysis as a design, with what was found of it: for drawings and reports.

    Nothing is solved. What it breaks stands in its extremes, what mends it as its conflict.
    """
    mend, conflict = found.mend, None
    if mend is not None and mend.limits:
        conflict = Conflict(
            limits=mend.limits, relaxations=mend.relaxations, evidence=mend.evidence
        )
    cam = given(found.spec)
    return design(found.spec, cam, found.extremes, [], [], 0.0, conflict)


def given(spec: DesignSpec) -> Cam:
    """The cam that a spec gives in full; InputError names the first thing that it leaves free."""
    for field, value in spec.left_free():
        raise InputError(
            field,
            value,
            "An analysis is of a cam that is given in full, and this leaves a choice.",
            "Name the law or give the number, or have it chosen: POST /v1/designs, synthesise().",
        )
    bounds = spec.follower.sizing(spec.base_radius_range()).bounds
    tables = smooth_tables(spec.stretches())
    return Cam(tables.stretches, tables.splines, tuple(low for low, _ in bounds))


def mend(spec: DesignSpec, cam: Cam, stop: float) -> Mend:
    """The smallest cams that keep every limit, and what each limit alone would have to be."""
    offsets: tuple[Offset, ...] = ("kept", "free") if spec.follower.adjustable() else ("kept",)
    sizes = [_resized(spec, cam, offset, stop) for offset in offsets]
    found = _synthesised(spec, stop)
    conflict = None if found is None else found.conflict
    if conflict is None:
        return Mend(sizes=sizes, limits=[], relaxations=[], evidence="no conflict was found")
    return Mend(
        sizes=sizes,
        limits=conflict.limits,
        relaxations=conflict.relaxations,
        evidence=conflict.evidence,
    )


def _resized(spec: DesignSpec, cam: Cam, offset: Offset, stop: float) -> SizeChange:
    """The smallest base radius, with the laws as they are."""
    follower = spec.follower.unsized()
    opened = dict.fromkeys(follower.adjustable()) if offset == "free" else {}
    freed = {"base_radius_mm": None, "follower": follower.model_copy(update=opened)}
    found = _synthesised(spec.model_copy(update=freed), stop)
    if found is None or found.status == "infeasible":
        return SizeChange(
            offset=offset, status=None if found is None else found.status, dimensions={},
            base_radius_change_mm=None, offset_change_mm=None, gap=None,
        )  # fmt: skip
    old, new = spec.follower.dimensions(cam.size), found.dimensions
    return SizeChange(
        offset=offset,
        status=found.status,
        dimensions=new,
        base_radius_change_mm=new["base_radius_mm"] - old["base_radius_mm"],
        offset_change_mm=new["offset_mm"] - old["offset_mm"] if "offset_mm" in new else None,
        changes={name: new[name] - old[name] for name in opened},
        gap=found.certificate.gap,
    )


def _synthesised(spec: DesignSpec, stop: float) -> Design | None:
    """The smallest cam that a spec allows; None where not even a conflict could be found.

    What the time allowed is taken as it is: it is certified, and its gap is stated.
    """
    try:
        return synthesise(spec.model_copy(update={"objective": BaseRadius()}), deadline=stop)
    except SolverFailed:
        return None
    except TimeBudgetExceeded as error:
        if error.best is None:
            raise
        best: Design = error.best
        return best
