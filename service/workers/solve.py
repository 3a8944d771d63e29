"""What a worker does: bytes of a spec in, bytes of an answer out. Nothing else crosses the wire."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from service.wire.errors import NothingFits
from service.wire.links import design_links, linkage_links, set_links, spatial_links, train_links
from synthesis.camset_spec import CamSetSpec
from synthesis.design import Design
from synthesis.dynamics import TrainSpec
from synthesis.exporters import DRAWINGS, Exporter, Made, Options
from synthesis.exporters.exporter import FileFormat
from synthesis.exporters.linkages import LINKAGE_FILES
from synthesis.findings import Analysis
from synthesis.linkages import LINKAGES
from synthesis.objectives import Objective
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.spec import SpatialCamSpec
from synthesis.spec import DesignSpec

if TYPE_CHECKING:
    from synthesis.pipeline import Near  # the solvers with it


@dataclass(frozen=True)
class Answer:
    """A finished design, set or analysis, and what lists show of it.

    Attributes:
        design: the response body.
        status: optimal, feasible or infeasible; of an analysis, holds or broken; of points, read.
        summary: the other fields of a list's row.
        seconds: time the core took.
        quantities: what a sweep trades: dimensions, objectives and what else was measured.
        id: of a design, otherwise empty.
        near: what a design leaves to a neighbouring one; stays in the worker.
    """

    design: bytes
    status: str
    summary: dict[str, Any]
    seconds: float
    quantities: dict[str, float] = field(default_factory=dict)
    id: str = ""
    near: Near | None = None


Task = Callable[[bytes, float], Answer]
PRICING = 0.8  # of the time there is, for what limits cost: then what is known by then is told


def solve(
    spec: bytes, budget_s: float, also: Sequence[Objective] = (), near: Near | None = None
) -> Answer:
    """Synthesise, and measure further objectives; runs in a worker process.

    ``near``: what a neighbouring design has left, to begin there.
    """
    from synthesis.pipeline import synthesise_beside  # solvers: not in the API's process

    def begun(asked: DesignSpec, deadline: float) -> tuple[Design, Near | None]:
        return synthesise_beside(asked, near, deadline=deadline)

    return answered(begun, spec, budget_s, also)


def answered(
    synthesise: Callable[[DesignSpec, float], tuple[Design, Near | None]],
    spec: bytes,
    budget_s: float,
    also: Sequence[Objective] = (),
) -> Answer:
    """The core's answer to a spec, ready for the store."""
    started = time.monotonic()
    asked = DesignSpec.model_validate_json(spec, strict=True)
    design, left = synthesise(asked, started + budget_s)
    links = design_links(design.id, has_cam=bool(design.motion))
    design = design.model_copy(update={"links": links})
    proven = design.certificate
    quantities = {**design.dimensions, **design.objectives}
    if also:
        from synthesis.answer import measured

        quantities |= measured(design, also)
    summary = {
        "dimensions": design.dimensions,
        "objective": proven.objective,
        "value": proven.value,
        "gap": proven.gap,
        "certified": proven.certified,
    }
    body = design.model_dump_json().encode()
    seconds = time.monotonic() - started
    return Answer(body, design.status, summary, seconds, quantities, design.id, left)


def solve_set(spec: bytes, budget_s: float) -> Answer:
    """Synthesise the cams of a set one after the other; runs in a worker process."""
    from synthesis.set_synthesis import synthesise_set

    started = time.monotonic()
    asked = CamSetSpec.model_validate_json(spec)
    found = synthesise_set(asked, deadline=started + budget_s)
    found = found.model_copy(update={"links": set_links(found.id, has_cams=found.has_cams)})
    summary = {"cams": len(found.cams), "fitting": sum(cam.has_cam for cam in found.cams)}
    body = found.model_dump_json().encode()
    return Answer(body, found.status, summary, time.monotonic() - started)


def solve_spatial(spec: bytes, budget_s: float) -> Answer:
    """Design a spatial cam; runs in a worker process."""
    from synthesis.spatial.pipeline import synthesise_spatial

    started = time.monotonic()
    asked = SpatialCamSpec.model_validate_json(spec)
    found = synthesise_spatial(asked, deadline=started + budget_s)
    links = spatial_links(found.id, found.machine, has_cam=bool(found.motion))
    found = found.model_copy(update={"links": links})
    summary = {"machine": found.machine, "dimensions": found.dimensions}
    body = found.model_dump_json().encode()
    return Answer(body, found.status, summary, time.monotonic() - started, {}, found.id)


def respond(spec: bytes, budget_s: float) -> Answer:
    """A follower train's response to its cam; runs in a worker process."""
    from synthesis.train_response import respond as responded

    started = time.monotonic()
    found = responded(TrainSpec.model_validate_json(spec), deadline=started + budget_s)
    found = found.model_copy(update={"links": train_links(found.id)})
    summary = {"modes_hz": [mode.natural_frequency_hz for mode in found.modes]}
    body = found.model_dump_json().encode()
    return Answer(body, "computed", summary, time.monotonic() - started)


def analyse(spec: bytes, budget_s: float) -> Answer:
    """Analyse a given cam; runs in a worker process."""
    from synthesis.analysis import analyse as analysed

    started = time.monotonic()
    asked = DesignSpec.model_validate_json(spec)
    found = analysed(asked, deadline=started + budget_s)
    status = "holds" if found.holds else "broken"
    summary = {"broken": found.broken}
    return Answer(found.model_dump_json().encode(), status, summary, time.monotonic() - started)


def pictured(analysis: bytes, name: str, options: Options) -> bytes:
    """A picture of an analysed cam; runs in a worker process."""
    from synthesis.analysis import as_design

    exporter = DRAWINGS[name]
    found = Analysis.model_validate_json(analysis)
    return exporter.write(as_design(found), options)


def confirm(design: bytes, budget_s: float) -> Answer:
    """Confirm a finished design; runs in a worker process."""
    from synthesis.confirmation import confirm as confirmed
    from synthesis.design import Design

    started = time.monotonic()
    found = confirmed(Design.model_validate_json(design))
    return Answer(found.model_dump_json().encode(), found.verdict, {}, time.monotonic() - started)


def read_back(cam: bytes, budget_s: float) -> Answer:
    """Read the motion back from a measured profile; runs in a worker process."""
    from synthesis.measured import MeasuredCam
    from synthesis.measured import read_back as read

    started = time.monotonic()
    found = read(MeasuredCam.model_validate_json(cam))
    summary = {"dimensions": found.dimensions}
    return Answer(found.model_dump_json().encode(), "read", summary, time.monotonic() - started)


def linked(kind: str, spec: bytes, budget_s: float) -> Answer:
    """Answer a question about a linkage of this kind; runs in a worker process."""
    linkage = LINKAGES[kind]
    started = time.monotonic()
    asked = linkage.spec.model_validate_json(spec)
    found = linkage.work(asked, started + budget_s)
    quantities = linkage.told(found)
    written = LINKAGE_FILES[kind].values() if quantities else ()
    files = [file.name for file in written if file.suits(found)]
    links = linkage_links(kind, found.id, files)
    body = found.model_copy(update={"links": links}).model_dump_json().encode()
    summary = {"quantities": quantities, "files": files}
    return Answer(body, found.status, summary, time.monotonic() - started, quantities, found.id)


def priced(design: bytes, budget_s: float) -> bytes:
    """What each limit of a finished design costs; runs in a worker process."""
    from synthesis.sensitivity import sensitivities

    deadline = time.monotonic() + PRICING * budget_s
    found = sensitivities(Design.model_validate_json(design), deadline)
    return found.model_dump_json().encode()


def file_of(design: bytes, exporter: Exporter[Any], options: Any) -> Made:
    """A file of a finished design; in a thread of the service, or in a worker process."""
    finished = Design.model_validate_json(design)
    if not (finished.motion or exporter.without_cam):
        raise NothingFits("No cam fits these limits: see conflict in the design for what would.")
    return exporter.whole(finished, options)


def spatial_file(design: bytes, exporter: FileFormat[SpatialDesign, Any], options: Any) -> Made:
    """The same of a spatial cam."""
    finished = SpatialDesign.model_validate_json(design)
    if not finished.motion:
        raise NothingFits("No cam fits these limits, so that there is none to draw.")
    return exporter.whole(finished, options)


def warm_up() -> None:
    """Import the solvers and run them once, so that the first design does not wait for that."""
    from synthesis.pipeline import synthesise

    synthesise(DesignSpec.model_validate(WARM_UP_SPEC))


WARM_UP_SPEC = {
    "program": [
        {"kind": "rise", "angle_deg": 90.0, "lift_mm": 10.0},
        {"kind": "return", "angle_deg": 90.0, "lift_mm": 10.0},
        {"kind": "dwell", "angle_deg": 180.0},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 5.0},
    "limits": [{"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0}],
    "tolerance": 0.05,
}
