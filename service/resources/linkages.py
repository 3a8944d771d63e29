"""/v1/linkages/{kind}: a resource for each kind of linkage in the registry."""

from __future__ import annotations

from functools import partial
from typing import Any

from service.resources.resource import Resource, file_of
from service.resources.views import LinkagePage
from service.wire.errors import ProblemType
from service.wire.links import linkage_links
from service.workers.tasks import solve_linkage
from synthesis.design.design import Status
from synthesis.design.identity import question_id
from synthesis.exporters import Made
from synthesis.machines.linkages import LINKAGES, Linkage
from synthesis.machines.linkages.files import LINKAGE_FILES, LinkageFile


def _file(linkage: Linkage, file: LinkageFile, body: bytes, options: Any) -> Made:
    found = linkage.answer.model_validate_json(body)
    if not linkage.summary(found):
        raise ProblemType.NOTHING_FITS("No lengths keep these wishes: see conflict in the answer.")
    return Made(file.write(found, options))


def _resource(linkage: Linkage) -> Resource:
    operation = linkage.name.replace("-", "_").removesuffix("s")
    return Resource(
        path=f"/v1/linkages/{linkage.name}",
        tag="linkages",
        noun=linkage.noun,
        plural=f"{linkage.noun}s",
        id_name="linkage_id",
        spec=linkage.spec,
        answer=linkage.answer,
        page=LinkagePage,
        examples=f"linkages/{linkage.name}",
        id_of=lambda spec: question_id(spec, linkage.noun),
        task=partial(solve_linkage, linkage.name),
        links=lambda id, summary: linkage_links(linkage.name, id, summary.get("files", ())),
        unknown=ProblemType.UNKNOWN_LINKAGE,
        title=linkage.title,
        text=f"{linkage.purpose} The same spec gives the same bytes.",
        answer_text="The answer, with links to its files.",
        status=Status,
        files=tuple(
            file_of(
                file, name, f"{operation}_{name.replace('.', '_')}", partial(_file, linkage, file),
                title=f"{file.title}, of a {linkage.noun}",
            )
            for name, file in LINKAGE_FILES[linkage.name].items()
        ),
    )  # fmt: skip


LINKAGE_RESOURCES = tuple(_resource(linkage) for linkage in LINKAGES.values())
