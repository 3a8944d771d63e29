"""analyse(spec) -> Analysis: judge a cam that is given in full.

Nothing is optimised. The certificate judges the cam and its enclosures summarise the curves; where
a limit is violated, the ordinary synthesis finds the size that would keep it.
"""

from __future__ import annotations

from typing import Literal

from synthesis.catalogue.objectives import BaseRadius
from synthesis.certify.curve_analysis import CurveAnalysis
from synthesis.certify.quantities import MeasuredCam
from synthesis.design.analysis import Analysis, Remedy, SizeChange
from synthesis.design.design import WITHOUT_CAM, Conflict, Design
from synthesis.design.identity import engine_version
from synthesis.errors import InputError, SolverFailed, TimeBudgetExceeded
from synthesis.numerics import clock
from synthesis.optimise.parameters.table_smoothing import smooth_tables
from synthesis.pipeline.advice import with_warnings
from synthesis.pipeline.assembly import Cam, certify_cam, design, dimensions
from synthesis.pipeline.synthesise import synthesise
from synthesis.spec.design_spec import DesignSpec

Offset = Literal["kept", "free"]


def analyse(spec: DesignSpec, *, deadline: float | None = None) -> Analysis:
    """Analyse a given cam: its curves, the limits that it violates, and sizes that would keep them.

    ``deadline`` is a ``time.monotonic()``; the spec's own budget counts as well.

    Raises:
        InputError: something is left free.
        TimeBudgetExceeded: time ran out while searching for such sizes.
    """
    stop = clock.now() + clock.seconds_left(spec.time_budget_s, deadline)
    cam = given_cam(spec)
    extremes = certify_cam(spec, cam)
    violated = [extreme.limit for extreme in extremes if not extreme.holds]
    curves = CurveAnalysis(MeasuredCam.of(cam.motion, spec.machine(), cam.size))
    judged = with_warnings(design(spec, cam, extremes, [], [], 0.0, None))
    return Analysis(
        name=spec.name,
        engine_version=engine_version(),
        holds=not violated,
        severity=judged.severity,
        warnings=judged.warnings,
        dimensions=dimensions(spec, cam),
        violated=violated,
        extremes=extremes,
        curves=curves.summaries(),
        jumps=curves.jumps(),
        undercut=curves.undercut(),
        self_crossing=curves.self_crossing(),
        forces=judged.forces,
        remedy=find_remedy(spec, cam, stop) if violated else None,
        spec=spec,
    )


def as_design(analysis: Analysis) -> Design:
    """The cam of an analysis as a design, for drawings and reports.

    Nothing is solved: violated limits are in its extremes, sizes that keep them in its conflict.
    """
    remedy, conflict = analysis.remedy, None
    if remedy is not None and remedy.limits:
        conflict = Conflict(
            limits=remedy.limits,
            relaxations=remedy.relaxations,
            evidence=remedy.evidence,
            proven=True,
        )
    cam = given_cam(analysis.spec)
    drawn = design(analysis.spec, cam, analysis.extremes, [], [], 0.0, conflict).model_copy(
        update={"severity": analysis.severity, "warnings": analysis.warnings}
    )
    # The one cam that there is has been measured: where it breaks a limit, none fits.
    return drawn if analysis.holds else drawn.model_copy(update={"status": "infeasible"})


def given_cam(spec: DesignSpec) -> Cam:
    """The cam that a spec gives in full.

    Raises:
        InputError: something is left free.
    """
    for field, value in spec.left_free():
        raise InputError(
            field,
            value,
            "An analysis needs a cam that is given in full, and this is left free.",
            "Name the law or give the number, or have it chosen: POST /v1/designs, synthesise().",
        )
    bounds = spec.follower.size_domain(spec.base_radius_range()).bounds
    tables = smooth_tables(spec.placed_segments())
    return Cam(tables.segments, tables.splines, tuple(low for low, _ in bounds))


def find_remedy(spec: DesignSpec, cam: Cam, stop: float) -> Remedy:
    """The smallest cams that keep every limit, and the value that each limit alone would need."""
    offsets: tuple[Offset, ...] = (
        ("kept", "free") if spec.follower.adjustable_dimensions() else ("kept",)
    )
    sizes = [_smallest_size(spec, cam, offset, stop) for offset in offsets]
    smallest = _smallest_cam(spec, stop)
    conflict = None if smallest is None else smallest.conflict
    if conflict is None:
        return Remedy(sizes=sizes, limits=[], relaxations=[], evidence="no conflict was found")
    return Remedy(
        sizes=sizes, limits=conflict.limits, relaxations=conflict.relaxations,
        evidence=conflict.evidence,
    )  # fmt: skip


def _smallest_size(spec: DesignSpec, cam: Cam, offset: Offset, stop: float) -> SizeChange:
    """The smallest base radius with the laws as they are."""
    follower = spec.follower
    opened = dict.fromkeys(follower.adjustable_dimensions()) if offset == "free" else {}
    left_out = {**dict.fromkeys(follower.redundant_fields), **opened}
    freed = {"base_radius_mm": None, "follower": follower.model_copy(update=left_out)}
    smallest = _smallest_cam(spec.model_copy(update=freed), stop)
    found = None if smallest is None or smallest.status in WITHOUT_CAM else smallest
    old, new = spec.follower.dimensions(cam.size), {} if found is None else found.dimensions
    changes = {name: new[name] - old[name] for name in ("base_radius_mm", "offset_mm", *opened)
               if name in new}  # fmt: skip
    return SizeChange(
        offset=offset,
        status=None if smallest is None else smallest.status,
        dimensions=new,
        base_radius_change_mm=changes.get("base_radius_mm"),
        offset_change_mm=changes.get("offset_mm"),
        changes={name: changes[name] for name in opened if name in changes},
        gap=None if found is None else found.certificate.gap,
    )


def _smallest_cam(spec: DesignSpec, stop: float) -> Design | None:
    """The smallest cam that a spec allows; None where not even a conflict could be found.

    Where time runs out the best cam so far is taken: it is certified, and its gap is stated.
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
