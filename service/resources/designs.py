"""/v1/designs."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from service.resources.resource import Resource, ResourceFile, file_of
from service.resources.views import DesignPage
from service.sweeps.store import design_of_item
from service.wire.errors import ProblemType
from service.wire.links import design_links
from service.workers.tasks import design_file
from synthesis.design.design import Design, Status
from synthesis.design.identity import design_id
from synthesis.exporters import MOTION_FORMATS, PICTURES, PROFILE_FORMATS, SOLID_FORMATS
from synthesis.spec.design_spec import DesignSpec

REPORT = "report.html"  # it has a route of its own: it may need a worker or not
FORMATS = {"profile": PROFILE_FORMATS, "motion": MOTION_FORMATS, "solid": SOLID_FORMATS}


def _files() -> Iterator[ResourceFile]:
    for part, formats in FORMATS.items():
        for exporter in formats.values():
            path = f"{part}.{exporter.name}"
            yield file_of(
                exporter, path, path.replace(".", "_"), partial(design_file, exporter),
                download_name=f"{part}{exporter.extension}",
            )  # fmt: skip
    for exporter in PICTURES.values():
        if exporter.name != REPORT:
            name = exporter.name
            yield file_of(exporter, name, name.replace(".", "_"), partial(design_file, exporter))


DESIGNS = Resource(
    path="/v1/designs",
    tag="designs",
    file_tag="files",
    noun="design",
    plural="designs",
    id_name="design_id",
    spec=DesignSpec,
    answer=Design,
    page=DesignPage,
    examples="",
    id_of=design_id,
    task=None,
    links=lambda id, summary: design_links(id, has_cam=bool(summary.get("dimensions"))),
    unknown=ProblemType.UNKNOWN_DESIGN,
    title="Synthesise a cam",
    text="""Chooses base radius, offset and spline laws together and proves that every limit holds.

    Infeasible is a result (status `infeasible`, with the conflict), not an error. The same spec
    gives the same id and the same bytes.
    """,
    answer_text="Dimensions, motion, extremes, certificate, report and links.",
    status=Status,
    elsewhere=design_of_item,
    files=tuple(_files()),
    marks_broken_limits=True,
    own_delete=True,
)
