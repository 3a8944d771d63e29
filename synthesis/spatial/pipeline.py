"""synthesise_spatial(spec) -> SpatialDesign: a spatial cam, settled and measured."""

from __future__ import annotations

import time
from collections.abc import Sequence

from synthesis.answer import Splines, segments
from synthesis.design import Certificate, Report, StageReport, Status, engine_version
from synthesis.errors import InputError
from synthesis.formulations.tables import smooth_tables
from synthesis.motion import Motion, Stretch
from synthesis.spatial.cam import SpatialCam, settled
from synthesis.spatial.design import Arc, SpatialDesign, SpatialWall, spatial_id
from synthesis.spatial.measuring import NO_BOUNDS, Bounds, measured
from synthesis.spatial.spec import SpatialCamSpec
from synthesis.units import DEGREE

GIVEN = Certificate(
    certified=False, objective="none", value=None, lower_bound=None,
    bound_over="nothing was chosen: the cam is given in full", gap=None,
)  # fmt: skip


def synthesise_spatial(spec: SpatialCamSpec, *, deadline: float | None = None) -> SpatialDesign:
    """Measure a spatial cam that is given in full.

    Args:
        spec: what is asked.
        deadline: ``time.monotonic()`` at which to stop.

    Raises:
        InputError: something is left free.
    """
    started = time.perf_counter()
    for field, value in spec.left_free():
        raise InputError(
            field,
            value,
            "A spatial cam is given in full, and this leaves a choice.",
            "Name the law or give the number.",
        )
    tables = smooth_tables(spec.stretches())
    sizes = spec.given_sizes()
    assert sizes is not None  # or something had been free
    cam = settled(spec, sizes, Motion.of(tables.stretches))
    return answered(spec, cam, tables.stretches, tables.splines, [], started)


def answered(
    spec: SpatialCamSpec,
    cam: SpatialCam,
    stretches: Sequence[Stretch],
    splines: Splines,
    stages: Sequence[StageReport],
    started: float,
    certificate: Certificate = GIVEN,
    bounds: Bounds = NO_BOUNDS,
) -> SpatialDesign:
    """The answer with a finished cam; ``started`` is a ``time.perf_counter()``."""
    extremes = measured(spec, cam, bounds)
    holds = all(extreme.holds for extreme in extremes)
    status: Status = "feasible" if holds else "infeasible"
    return SpatialDesign(
        id=spatial_id(spec),
        name=spec.name,
        engine_version=engine_version(),
        status=status,
        rotation=spec.rotation,
        speed_rpm=spec.speed_rpm,
        machine=spec.machine.kind,
        dimensions=dict(spec.machine.dimensions(cam.sizes)),
        motion=segments(spec.program, spec.machine.travel, stretches, splines),
        walls=_walls(cam),
        extremes=extremes,
        certificate=certificate.model_copy(update={"certified": holds}),
        report=Report(stages=list(stages), seconds=time.perf_counter() - started),
        spec=spec,
    )


def _walls(cam: SpatialCam) -> list[SpatialWall]:
    return [
        SpatialWall(
            name=wall.name,
            roller=wall.seat.number,
            side=wall.letter,
            arcs=[Arc(start_deg=a / DEGREE, end_deg=b / DEGREE) for a, b in wall.spans],
        )
        for wall in cam.walls
    ]
