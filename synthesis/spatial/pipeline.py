"""synthesise_spatial(spec) -> SpatialDesign: a spatial cam, settled and measured."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

from synthesis import clock
from synthesis.answer import segments
from synthesis.design import Certificate, Report, StageReport, engine_version
from synthesis.errors import InputError
from synthesis.formulations.cams.rejoined import Splines
from synthesis.formulations.free_numbers.tables import Tables, smooth_tables
from synthesis.motion import Motion, Stretch
from synthesis.spatial.cam import SpatialCam, settled
from synthesis.spatial.design import Arc, SpatialDesign, SpatialWall, spatial_id
from synthesis.spatial.measuring import Bound, measured
from synthesis.spatial.spec import SpatialCamSpec
from synthesis.units import DEGREE

if TYPE_CHECKING:
    from synthesis.spatial.formulations.optimise import Sized

DRAWN_IN = (1e-7, 1e-6, 1e-5)  # relative amounts by which limits are tightened, in turn
GIVEN = Certificate(
    certified=False, objective="none", value=None, lower_bound=None,
    bound_over="nothing was chosen: the cam is given in full", gap=None,
)  # fmt: skip


def synthesise_spatial(spec: SpatialCamSpec, *, deadline: float | None = None) -> SpatialDesign:
    """Measure a spatial cam that is given in full, or choose what is left free and measure it.

    Args:
        spec: what is asked.
        deadline: ``time.monotonic()`` at which to stop.

    Raises:
        InputError: numbers of the program are left free.
    """
    started, stop = time.perf_counter(), inf if deadline is None else deadline
    for field, value in spec.left_free():
        raise InputError(
            field,
            value,
            "Angles and lifts of a spatial cam's program are given, and this leaves a choice.",
            "Give the number.",
        )
    tables = smooth_tables(spec.stretches(), stop)
    sizes = spec.given_sizes()
    if not spec.given:
        return _chosen(spec, tables, stop, started)
    assert sizes is not None
    cam = settled(spec, sizes, Motion.of(tables.stretches))
    return answered(spec, cam, tables.stretches, tables.splines, [], started)


def _chosen(spec: SpatialCamSpec, tables: Tables, stop: float, started: float) -> SpatialDesign:
    """What is left free chosen, limits drawn in a little more until the measured cam keeps them."""
    from synthesis.spatial.formulations.optimise import sized

    stages: list[StageReport] = []
    for number, tighten in enumerate(DRAWN_IN):
        found = sized(spec, tables, stop, tighten, ribs=number > 0)  # most have room for theirs
        stages += [StageReport(**asdict(stage)) for stage in found.stages]
        if found.sizes is None:
            break
        cam = settled(spec, found.sizes, found.motion)
        proof = _proof(spec, found.sizes, found.lower, found.over)
        answer = answered(spec, cam, found.stretches, found.splines, stages, started, proof)
        if answer.status != "infeasible" or clock.now() >= stop:
            return answer
    if found.sizes is not None:
        return answer
    return _refused(spec, tables, found, stages, stop, started)


def _proof(
    spec: SpatialCamSpec, sizes: Mapping[str, float], lower: float, over: str
) -> Certificate:
    name = spec.machine.sought
    value = sizes[name]
    return Certificate(
        certified=False, objective=name, value=value, lower_bound=lower, bound_over=over,
        gap=max(value - lower, 0.0) / value,
    )  # fmt: skip


def _refused(
    spec: SpatialCamSpec,
    tables: Tables,
    found: Sized,
    stages: Sequence[StageReport],
    stop: float,
    started: float,
) -> SpatialDesign:
    """The answer where nothing fits."""
    from synthesis.spatial.formulations.conflict import diagnosed

    conflict = diagnosed(spec, tables, found, stop)
    nothing = Certificate(
        certified=False, objective=spec.machine.sought, value=None,
        lower_bound=found.lower if isfinite(found.lower) else None, bound_over=found.over, gap=None,
    )  # fmt: skip
    return SpatialDesign(
        **_head(spec), status="infeasible", dimensions={}, motion=[], walls=[], extremes=[],
        certificate=nothing, conflict=conflict, report=_report(stages, started),
    )  # fmt: skip


def answered(
    spec: SpatialCamSpec,
    cam: SpatialCam,
    stretches: Sequence[Stretch],
    splines: Splines,
    stages: Sequence[StageReport],
    started: float,
    certificate: Certificate = GIVEN,
) -> SpatialDesign:
    """The answer with a finished cam; ``started`` is a ``time.perf_counter()``."""
    extremes = measured(spec, cam, bounds(spec))
    holds = all(extreme.holds for extreme in extremes)
    close = certificate.gap is not None and certificate.gap <= spec.tolerance
    return SpatialDesign(
        **_head(spec),
        status="infeasible" if not holds else "optimal" if close else "feasible",
        dimensions=dict(spec.machine.dimensions(cam.sizes)),
        motion=segments(spec.program, spec.machine.travel, stretches, splines),
        walls=_walls(cam),
        extremes=extremes,
        certificate=certificate.model_copy(update={"certified": holds}),
        report=_report(stages, started),
    )


def bounds(spec: SpatialCamSpec) -> dict[str, Bound]:
    """The tightest bound of every quantity that is limited."""
    found: dict[str, Bound] = {}
    for position, limit in enumerate(spec.limits):
        known = found.get(limit.quantity)
        if known is None or (limit.bound < known.value) is limit.upper:
            found[limit.quantity] = Bound(limit.bound, f"limits/{position}/{limit.field}")
    return found


def _head(spec: SpatialCamSpec) -> dict[str, Any]:
    """What every answer begins with."""
    return {
        "id": spatial_id(spec), "name": spec.name, "engine_version": engine_version(),
        "rotation": spec.rotation, "speed_rpm": spec.speed_rpm, "machine": spec.machine.kind,
        "spec": spec,
    }  # fmt: skip


def _report(stages: Sequence[StageReport], started: float) -> Report:
    return Report(stages=list(stages), seconds=time.perf_counter() - started)


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
