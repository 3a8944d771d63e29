"""/v1/sweeps/{id}/proofs.zip: proof files of chosen items, in one archive."""

from __future__ import annotations

import zlib
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.contract.documentation import file_response
from service.resources.records import DESIGNS, write_design
from service.routes.resource_routes import content_of, download_headers, in_worker
from service.routes.sweeps import RequestedSweep, find_item
from service.state import Parts
from service.wire.conditional import IN_PARTS, not_modified, tag_of
from service.wire.errors import ProblemType
from service.workers.tasks import PROOF
from synthesis.exporters.bundle import MEDIA_TYPE, archive
from synthesis.exporters.options import Options

router = APIRouter(prefix="/v1/sweeps", tags=["sweeps"])
MAX_PROOFS = 50  # of one archive: each takes as long as its design


@router.get(
    "/{sweep_id}/proofs.zip",
    response_class=Response,
    responses=file_response(content_of(MEDIA_TYPE)),
    summary="Proofs of chosen items",
)
async def get_sweep_proofs_zip(
    request: Request,
    sweep: RequestedSweep,
    parts: Parts,
    item: Annotated[
        list[int],
        Query(min_length=1, max_length=MAX_PROOFS, description="Item by number; may be repeated."),
    ],
) -> Response:
    """A ZIP archive with the file `proof.json` of each item's design, named by its number.

    `python3 check.py proofs.zip` checks all of them. Each takes as long as its design.
    """
    chosen = sorted(set(item))
    rows = {number: await find_item(sweep, number, parts) for number in chosen}
    for number, row in rows.items():
        if row.design_id is None:
            raise ProblemType.NOT_DONE(f"Item {number} of sweep {sweep.id} failed: no design.")
    tag = tag_of(sweep.id, "proofs", repr(chosen), zlib.ZLIB_RUNTIME_VERSION)
    known = not_modified(request, tag)
    if known is not None:
        return known
    designs = parts.jobs[DESIGNS.path]
    files = []
    for number, row in rows.items():
        _, design = await designs.find_done(row.design_id or "", parts.owner)
        made = await in_worker(request, parts, partial(write_design, PROOF, design, Options()))
        files.append((f"item-{number}.proof.json", made.data))
    headers = download_headers(sweep.name, "proofs.zip", MEDIA_TYPE) | {"ETag": f'"{tag}"'}
    return Response(archive(files), headers=headers | IN_PARTS, media_type=MEDIA_TYPE)
