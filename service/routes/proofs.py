"""Proof files: of a design, and of chosen items of a sweep in one archive.

A proof takes as long as its design, or longer: it is kept as answers are, and work on the same one
is shared.
"""

from __future__ import annotations

import zlib
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.contract.documentation import file_response
from service.resources.records import DESIGNS, PROOFS, proof_question
from service.resources.resource import Accepted
from service.routes.files import content_of, download_headers, name_of_file, with_words_for_files
from service.routes.resource_routes import UNDER_WAY, KnownTag, Prefer, failure
from service.routes.sweeps import RequestedSweep, find_item
from service.state import Parts, State
from service.storage.tables import AnswerRow
from service.wire.conditional import IN_PARTS, not_modified, tag_of
from service.wire.errors import ProblemType
from synthesis.exporters.bundle import MEDIA_TYPE, archive

router = APIRouter()
MAX_PROOFS = 50  # of one archive: each takes as long as its design
JSON_FILE = "application/json"


@router.get(
    f"{DESIGNS.path}/{{design_id}}/proof.json",
    tags=["files"],
    response_class=Response,
    responses={**file_response(content_of(JSON_FILE)), **UNDER_WAY},
    summary=PROOFS.title,
)
async def get_proof_json(
    request: Request,
    design_id: str,
    parts: Parts,
    prefer: Prefer = "",
    if_none_match: KnownTag = None,
) -> Response:
    """Every claim with its witness, or why it is not covered; made once, in as long as the design.

    `camwright proof design.json --checker check.py` writes its checker, one file of Python.
    """
    jobs = parts.jobs[DESIGNS.path]
    row = await jobs.find_done(design_id, parts.owner)
    tag = tag_of(row.etag or "", "proof.json")
    known = not_modified(request, tag)
    if known is not None:
        return known
    design = await jobs.body(row)
    kept = await _proof(request, parts, row, design, wait="respond-async" not in prefer.lower())
    if kept.state == "accepted":
        return _accepted_response(request, row, kept)
    failed = failure(request, kept)
    if failed is not None:
        return failed
    name = name_of_file(DESIGNS, row, "proof.json")
    headers = download_headers(row.name, name, JSON_FILE) | {"ETag": f'"{tag}"'}
    return Response(kept.body, headers=headers | IN_PARTS, media_type=JSON_FILE)


def _accepted_response(request: Request, row: AnswerRow, kept: AnswerRow) -> Response:
    path = request.url.path
    fields = {**PROOFS.fields_of(kept), "id": row.id, "links": {"self": path}}
    body = Accepted(**fields).model_dump_json()
    headers = {"Location": path, "Retry-After": "1", "Preference-Applied": "respond-async"}
    return Response(body, 202, headers, JSON_FILE)


async def _proof(
    request: Request, parts: State, row: AnswerRow, design: bytes, *, wait: bool = True
) -> AnswerRow:
    """The proof file of a finished design, made once; accepted alone where nobody waits for it."""
    jobs, asked = parts.jobs[PROOFS.path], proof_question(row, design)
    id = PROOFS.id_of(asked)
    kept = await jobs.answers.find(id, parts.owner)
    if kept is not None and kept.state == "done":
        return kept
    async with parts.quotas.room(parts.caller, id):
        with jobs.room(id):  # who is refused by then holds nothing
            kept = await jobs.answers.claim(id, parts.owner)
            if kept is not None and kept.state == "done":
                return kept
            if not wait:
                return await jobs.accept(asked)
        budget_s = parts.settings.budget_s(None)
        answer = jobs.answer(asked, kept, parts.owner)
        return await with_words_for_files(request, budget_s, answer)


@router.get(
    "/v1/sweeps/{sweep_id}/proofs.zip",
    tags=["sweeps"],
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
    """A ZIP archive with `proof.json` of each item's design; `python3 check.py` checks them all."""
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
        of = await designs.find_done(row.design_id or "", parts.owner)
        kept = await _proof(request, parts, of, await designs.body(of))
        failed = failure(request, kept)
        if failed is not None:
            return failed
        files.append((f"item-{number}.proof.json", kept.body or b""))
    headers = download_headers(sweep.name, "proofs.zip", MEDIA_TYPE) | {"ETag": f'"{tag}"'}
    return Response(archive(files), headers=headers | IN_PARTS, media_type=MEDIA_TYPE)
