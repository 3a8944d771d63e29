"""What workers do: bytes of a question in, bytes of an answer out.

Solvers are imported in the functions: the process that answers requests does not load them.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from service.wire.errors import ProblemType
from service.workers.measured import note
from synthesis.catalogue.objectives import Objective
from synthesis.design.analysis import Analysis
from synthesis.design.design import Design, Effort
from synthesis.exporters import (
    DRAWINGS,
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    SOLID_FORMATS,
    FileContent,
)
from synthesis.exporters.exporter import FileFormat, compact_json
from synthesis.machines.dynamics import TrainSpec
from synthesis.machines.dynamics.files import TRAIN_FILES
from synthesis.machines.linkages import LINKAGES
from synthesis.machines.linkages.files import LINKAGE_FILES
from synthesis.machines.spatial.files import formats_of
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.spec.cam_set import CamSetSpec
from synthesis.spec.design_spec import DesignSpec

if TYPE_CHECKING:
    from synthesis.pipeline.synthesise import Neighbour


@dataclass(frozen=True)
class Answer:
    """The answer to a question, ready to be stored.

    Attributes:
        body: the response body.
        status: optimal, feasible, unsolved or infeasible; of an analysis, holds or violated; of
            points, read.
        summary: the other fields of a list's row.
        seconds: time that it took.
        quantities: what a sweep measures: dimensions, objectives and others, by name with unit.
        id: of a design, otherwise empty.
        warm_start: what a neighbouring design may begin with; stays in the worker.
    """

    body: bytes
    status: str
    summary: Mapping[str, Any]
    seconds: float
    quantities: Mapping[str, float] = field(default_factory=dict)
    id: str = ""
    warm_start: Neighbour | None = None


Task = Callable[[bytes, float], Answer]  # question and time budget [s] to the answer
SENSITIVITY_SHARE = 0.8  # of the time budget: what is known by then is reported
DESIGN_FORMATS = {"profile": PROFILE_FORMATS, "motion": MOTION_FORMATS, "solid": SOLID_FORMATS}


def prove_design(asked: bytes, _budget_s: float) -> Answer:
    """The proof file of a finished design: JSON with the design's own in it."""
    from synthesis.pipeline.proof_file import proof

    started = time.monotonic()
    found = proof(Design.model_validate_json(json.loads(asked)["design"]))
    whole = all(claim["proven"] for claim in found["claims"])
    seconds = time.monotonic() - started
    return Answer(compact_json(found), "proven" if whole else "proven in part", {}, seconds)


def links_to(path: str, id: str, files: Iterable[str]) -> dict[str, str]:
    """Addresses of an answer and of its files; ``path`` of the collection."""
    self = f"{path}/{id}"
    return {"self": self, **{name: f"{self}/{name}" for name in files}}


def _answer(
    result: Any,
    status: str,
    started: float,
    summary: Mapping[str, Any],
    path: str = "",
    files: Iterable[str] = (),
    stages: Sequence[Effort] = (),
    **more: Any,
) -> Answer:
    """An answer as it is stored; where its collection's path is given, with links to its files."""
    note(status, time.monotonic() - started, stages)
    if path:
        files = list(files)
        result = result.model_copy(update={"links": links_to(path, result.id, files)})
        summary = {**summary, "files": files}
    body = result.model_dump_json().encode()
    return Answer(body, status, summary, time.monotonic() - started, **more)


def solve_design(
    spec: bytes,
    budget_s: float,
    objectives: Sequence[Objective] = (),
    warm_start: Neighbour | None = None,
) -> Answer:
    """Synthesise a cam; measure further objectives, begin with what a neighbour has left."""
    from synthesis.pipeline.synthesise import synthesise

    return design_answer(synthesise, spec, budget_s, objectives, warm_start)


def design_answer(
    synthesise: Callable[..., Design],
    spec: bytes,
    budget_s: float,
    objectives: Sequence[Objective] = (),
    warm_start: Neighbour | None = None,
) -> Answer:
    """The design that ``synthesise`` makes of a spec, and the values of further objectives."""
    started = time.monotonic()
    question = DesignSpec.model_validate_json(spec, strict=True)
    neighbours = [] if warm_start is None else [warm_start]
    design = synthesise(question, deadline=started + budget_s, neighbours=neighbours)
    certificate = design.certificate
    quantities = {**design.dimensions, **design.objectives}
    if objectives:
        from synthesis.pipeline.assembly import measured

        quantities |= measured(design, objectives)
    summary = {
        "dimensions": design.dimensions,
        "objective": certificate.objective,
        "value": certificate.value,
        "gap": certificate.gap,
        "certified": certificate.certified,
        "severity": design.severity,
    }
    has_cam = bool(design.motion)
    points = [f"{part}.{name}" for part, formats in DESIGN_FORMATS.items() for name in formats]
    others = [name for name, each in PICTURES.items() if has_cam or each.without_cam]
    return _answer(
        design, design.status, started, summary, "/v1/designs",
        [*(points if has_cam else ()), *others, "proof.json"], design.report.stages,
        quantities=quantities, id=design.id, warm_start=neighbours[-1] if neighbours else None,
    )  # fmt: skip


def solve_cam_set(spec: bytes, budget_s: float) -> Answer:
    """Synthesise the cams of a set, one after the other."""
    from synthesis.studies.cam_set import synthesise_set

    started = time.monotonic()
    result = synthesise_set(CamSetSpec.model_validate_json(spec), deadline=started + budget_s)
    summary = {"cams": len(result.cams), "solved": sum(cam.has_cam for cam in result.cams)}
    files = ("timing.svg", "bundle.zip") if result.has_cams else ()
    stages = [stage for cam in result.cams for stage in cam.design.report.stages]
    return _answer(result, result.status, started, summary, "/v1/cam-sets", files, stages)


def solve_spatial_cam(spec: bytes, budget_s: float) -> Answer:
    """Synthesise a spatial cam."""
    from synthesis.machines.spatial.pipeline import synthesise_spatial

    started = time.monotonic()
    question = SpatialCamSpec.model_validate_json(spec)
    result = synthesise_spatial(question, deadline=started + budget_s)
    summary = {"machine": result.machine, "dimensions": result.dimensions}
    files = formats_of(result.machine) if result.motion else ()
    stages = result.report.stages
    return _answer(result, result.status, started, summary, "/v1/spatial-cams", files, stages)


def compute_train_response(spec: bytes, budget_s: float) -> Answer:
    """Compute a follower train's response to its cam."""
    from synthesis.machines.dynamics.report import respond

    started = time.monotonic()
    result = respond(TrainSpec.model_validate_json(spec), deadline=started + budget_s)
    summary = {"modes_hz": [mode.natural_frequency_hz for mode in result.modes]}
    files = [file.name for file in TRAIN_FILES]
    return _answer(result, "computed", started, summary, "/v1/train-responses", files)


def analyse_cam(spec: bytes, budget_s: float) -> Answer:
    """Analyse a given cam."""
    from synthesis.studies.analyse import analyse

    started = time.monotonic()
    result = analyse(DesignSpec.model_validate_json(spec), deadline=started + budget_s)
    status = "holds" if result.holds else "violated"
    summary = {"violated": result.violated, "files": list(DRAWINGS)}
    return _answer(result, status, started, summary)


def analyse_profile(cam: bytes, budget_s: float) -> Answer:
    """Read the motion back from a measured profile."""
    from synthesis.studies.measured import MeasuredCam, read_back

    started = time.monotonic()
    result = read_back(MeasuredCam.model_validate_json(cam))
    return _answer(result, "read", started, {"dimensions": result.dimensions})


def solve_linkage(kind: str, spec: bytes, budget_s: float) -> Answer:
    """Analyse or size a linkage of a kind."""
    linkage = LINKAGES[kind]
    started = time.monotonic()
    result = linkage.solve(linkage.spec.model_validate_json(spec), started + budget_s)
    quantities = linkage.summary(result)
    formats = LINKAGE_FILES[kind].values() if quantities else ()
    files = [file.name for file in formats if file.suits(result)]
    summary = {"quantities": quantities}
    return _answer(result, result.status, started, summary, f"/v1/linkages/{kind}", files)


def confirm_design(design: bytes) -> bytes:
    """Measure the certificate of a finished design again, in ball arithmetic, as JSON."""
    from synthesis.certify.second import confirm

    return confirm(Design.model_validate_json(design)).model_dump_json().encode()


def design_sensitivities(design: bytes, budget_s: float) -> bytes:
    """How the objective of a finished design changes with each limit, as JSON."""
    from synthesis.studies.sensitivity import sensitivities

    deadline = time.monotonic() + SENSITIVITY_SHARE * budget_s
    result = sensitivities(Design.model_validate_json(design), deadline)
    return result.model_dump_json().encode()


def write_file(
    answer: type[BaseModel],
    drawable: Callable[[Any], object],
    nothing: str,
    file: FileFormat[Any, Any],
    body: bytes,
    options: Any,
) -> FileContent:
    """A file of an answer.

    Args:
        answer: its model. drawable: whether there is something to draw; of designs some files say
            why there is not. nothing: the problem where there is not. body: of the answer.
    """
    finished = answer.model_validate_json(body)
    if not (drawable(finished) or getattr(file, "without_cam", False)):
        raise ProblemType.NOTHING_FITS(nothing)
    return file.content(finished, options)


def write_picture(picture: FileFormat[Design, Any], analysis: bytes, options: Any) -> FileContent:
    """A picture of an analysed cam. A table's law is smoothed for it again, by a solver."""
    from synthesis.studies.analyse import as_design

    design = as_design(Analysis.model_validate_json(analysis))
    return FileContent(picture.write(design, options))


def warm_up() -> None:
    """Import the solvers and run them once, so that the first design does not wait for that."""
    from synthesis.pipeline.synthesise import synthesise

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
