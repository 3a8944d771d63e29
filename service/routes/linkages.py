"""/v1/linkages/{kind}: a resource for each kind of linkage in the registry, all alike."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from typing import Any

from fastapi import APIRouter, Request, Response

from service.contract.documentation import spec_body
from service.contract.examples import LINKAGES as EXAMPLES
from service.resources.views import LinkagePage
from service.routes.collection import Kept, Said, declare
from service.routes.download import Download, in_thread
from service.routes.kept import WithStatus, done
from service.routes.offering import Offer, offer
from service.state import State
from service.wire.errors import NothingFits
from synthesis.exporters import Made
from synthesis.exporters.linkages import LINKAGE_FILES, LinkageFile
from synthesis.linkages import LINKAGES, Linkage

router = APIRouter(prefix="/v1/linkages", tags=["linkages"])


def _made(linkage: Linkage, body: bytes, file: LinkageFile, options: Any) -> Made:
    found = linkage.found.model_validate_json(body)
    if not linkage.told(found):
        raise NothingFits("No lengths keep these wishes: see conflict in the answer.")
    return Made(file.write(found, options))


async def _file(
    linkage: Linkage, file: LinkageFile, request: Request, parts: State, name: str, options: Any
) -> Response:
    row, body = await done(parts.linkages[linkage.name], name)
    make = in_thread(partial(_made, linkage, body, file, options))
    made_by = (file.name, repr(asdict(options)))
    return await Download(file.name, file.media_type).sent(request, row, made_by, make)


def _resource(linkage: Linkage) -> None:
    """The routes of one kind."""
    kind, noun = linkage.name.replace("-", "_"), linkage.noun
    one = kind.removesuffix("s")
    collection = Kept(
        jobs=lambda parts: parts.linkages[linkage.name],
        one=one,
        many=kind,
        id="linkage_id",
        found=linkage.found,
        page=LinkagePage,
        on_page="Linkages on a page.",
        body=spec_body(f"{EXAMPLES}/{linkage.name}", linkage.spec.__name__),
        status=WithStatus,
        path=f"/{linkage.name}",
    )
    declare(
        router,
        collection,
        create=Said(linkage.title, f"{linkage.purpose} The same spec gives the same bytes."),
        list=f"List {noun}s",
        get=Said(
            f"A {noun}",
            "As it was answered; 202 while it is being worked on, the problem where it failed.",
        ),
        delete=Said(f"Forget a {noun}", "One being worked on is stopped."),
    )
    for name, file in LINKAGE_FILES[linkage.name].items():
        offered = Offer(
            file,
            f"{collection.path_of_one}/{name}",
            f"get_{one}_{name.replace('.', '_')}",
            file.purpose,
            of=f", of a {noun}",
        )
        offer(router, offered, collection.id, partial(_file, linkage, file))


for _linkage in LINKAGES.values():
    _resource(_linkage)
