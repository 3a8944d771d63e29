"""synthesise_spatial(spec) -> SpatialDesign: from a spec to a measured and certified spatial cam.

    SpatialCamSpec -> laws and sizes (``sizing``) -> SpatialCam -> extremes (``measuring``) ->
    answer

A cam that the measurement refuses is sized again with limits tightened more, as in
``pipeline.synthesise``. The two do not share a loop: the planar one orders several objectives,
certifies segment by segment and grows base circles; here there is one objective, and the
measurement takes extremes over whole walls.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict
from math import inf, isfinite
from typing import TYPE_CHECKING

from synthesis.catalogue.motion import Motion
from synthesis.design.design import WITHOUT_CAM, Certificate, Conflict, Effort, Report, Status
from synthesis.design.identity import engine_version
from synthesis.errors import InputError
from synthesis.machines.spatial.advice import with_warnings
from synthesis.machines.spatial.cam import SpatialCam, build_cam
from synthesis.machines.spatial.design import Arc, SpatialDesign, SpatialWall, spatial_design_id
from synthesis.machines.spatial.measuring.measure import measure
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics import clock
from synthesis.optimise.parameters.table_smoothing import smooth_tables
from synthesis.optimise.recovery.junction_repair import Splines
from synthesis.pipeline.assembly import segment_motions
from synthesis.units import DEGREE

if TYPE_CHECKING:
    from synthesis.machines.spatial.sizing.size_cam import SizingResult

TIGHTENINGS = (1e-7, 1e-6, 1e-5)  # relative amounts by which limits are tightened, in turn
GIVEN = Certificate(
    certified=False, objective="none", value=None, lower_bound=None,
    bound_valid_for="nothing was chosen: the cam is given in full", gap=None,
)  # fmt: skip


def synthesise_spatial(spec: SpatialCamSpec, *, deadline: float | None = None) -> SpatialDesign:
    """Measure a spatial cam that is given in full, or choose what is left free and measure it.

    ``deadline`` is the ``time.monotonic()`` at which to stop.

    Raises:
        InputError: numbers of the program are left free.
    """
    started, stop = time.perf_counter(), inf if deadline is None else deadline
    for field, value in spec.left_free():
        raise InputError(
            field,
            value,
            "A spatial cam's program cannot leave angles or lifts free yet.",
            "Give the number.",
        )
    tables = smooth_tables(spec.placed_segments(), stop)
    sizes, stages = spec.given_sizes(), list[Effort]()
    if sizes is not None and not spec.has_free_law:
        cam = build_cam(spec, sizes, Motion.of(tables.segments))
        return _answer(spec, stages, started, GIVEN, cam, tables.splines)
    # Imported on demand: cams that are given in full need no optimiser.
    from synthesis.machines.spatial.sizing.infeasibility import diagnose
    from synthesis.machines.spatial.sizing.size_cam import size_cam

    for number, tighten in enumerate(TIGHTENINGS):
        # Most cams have room for their ribs; measuring these waits until a cam is refused.
        result = size_cam(spec, tables, stop, tighten, ribs=number > 0)
        stages += [Effort(**asdict(stage)) for stage in result.stages]
        proof = _certificate(spec, result)
        if result.sizes is None:
            conflict = diagnose(spec, tables, result, stop)
            return _answer(spec, stages, started, proof, None, {}, conflict)
        cam = build_cam(spec, result.sizes, result.motion)
        design = _answer(spec, stages, started, proof, cam, result.splines)
        if design.status not in WITHOUT_CAM or clock.now() >= stop:
            break
    return design


def _certificate(spec: SpatialCamSpec, result: SizingResult) -> Certificate:
    """What is proven of the minimised dimension [mm]; not yet of the cam."""
    field, lower = spec.machine.size_field, result.lower if isfinite(result.lower) else None
    value = None if result.sizes is None else result.sizes[field]
    gap = None if value is None or lower is None else max(value - lower, 0.0) / value
    return Certificate(
        certified=False, objective=field, value=value, lower_bound=lower,
        bound_valid_for=result.valid_for, gap=gap,
    )  # fmt: skip


def _answer(
    spec: SpatialCamSpec,
    stages: Sequence[Effort],
    started: float,
    certificate: Certificate,
    cam: SpatialCam | None,
    splines: Splines,
    conflict: Conflict | None = None,
) -> SpatialDesign:
    """The answer with its warnings; ``started`` is a ``time.perf_counter()``.

    Its cam is measured if it has one.
    """
    extremes = [] if cam is None else measure(spec, cam)
    holds = cam is not None and all(extreme.holds for extreme in extremes)
    within = certificate.gap is not None and certificate.gap <= spec.tolerance
    segments = cam.motion.segments if cam else ()
    status: Status = "optimal" if within else "feasible"
    if not holds:
        proven = certificate is GIVEN or (conflict is not None and conflict.proven)
        status = "infeasible" if proven else "unsolved"
    walls = [
        SpatialWall(
            name=wall.name, roller=wall.seat.number, side=wall.letter,
            arcs=[Arc(start_deg=a / DEGREE, end_deg=b / DEGREE) for a, b in wall.spans],
        )
        for wall in (cam.walls if cam else ())
    ]  # fmt: skip
    design = SpatialDesign(
        id=spatial_design_id(spec), name=spec.name, engine_version=engine_version(),
        status=status,
        rotation=spec.rotation, speed_rpm=spec.speed_rpm, machine=spec.machine.kind,
        dimensions=dict(spec.machine.dimensions(cam.sizes)) if cam else {},
        motion=segment_motions(spec.program, spec.machine.travel, segments, splines),
        walls=walls, extremes=extremes, conflict=conflict,
        certificate=certificate.model_copy(update={"certified": holds}),
        report=Report(stages=list(stages), seconds=time.perf_counter() - started), spec=spec,
    )  # fmt: skip
    return with_warnings(design)
