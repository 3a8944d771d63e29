"""What designs alone have: sensitivities, confirmation, the report, and DELETE."""

from __future__ import annotations

import json
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.contract.documentation import etag_response, problems
from service.resources.records import DESIGNS, NO_CAM, PROOFS, REPORT, proof_question, write_design
from service.resources.resource import ResourceFile
from service.routes.files import add_file_route, make_in_worker, send_file
from service.routes.resource_routes import KnownTag
from service.state import Parts, State
from service.storage.tables import AnswerRow
from service.sweeps.views import sweep_path
from service.wire.conditional import not_modified, tag_of
from service.wire.errors import ProblemType
from service.workers.tasks import confirm_design, design_sensitivities
from synthesis.certify.second import Confirmation
from synthesis.design.analysis import Sensitivities
from synthesis.exporters import MOTION_FORMATS, PICTURES, PROFILE_FORMATS, report_with
from synthesis.exporters.options import Colours, PictureOptions

router = APIRouter()


@router.get(
    "/v1/designs/{design_id}/sensitivities",
    tags=["designs"],
    response_model=Sensitivities,
    responses={**etag_response(), **problems(404, 409, 504)},
    summary="What each limit costs",
)
async def get_design_sensitivities(
    request: Request, design_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """How the objective changes with every limit, range, window and point, to first order.

    In the limit's own units, as in: 1 deg more pressure angle makes the base radius 0.8 mm smaller.
    For every follower and objective, curvature included: multipliers of the cone program, or of the
    local optimum with every limit in it, each confirmed by solving again with the number a little
    larger and smaller. Where the two sides differ, both are given; what is not confirmed is listed
    as such, and what was not reached in time.
    """
    row = await parts.jobs[DESIGNS.path].find_done(design_id, parts.owner)
    tag = tag_of(row.etag or "", "sensitivities")
    return not_modified(request, tag) or Response(
        await _sensitivities(parts, row), 200, {"ETag": f'"{tag}"'}, "application/json"
    )


async def _sensitivities(parts: State, row: AnswerRow) -> bytes:
    design = await parts.jobs[DESIGNS.path].body(row)
    budget_s = parts.settings.time_budget_s
    async with parts.quotas.core(parts.caller, budget_s):
        return await parts.engine.run(design_sensitivities, design, budget_s, budget_s=budget_s)


@router.get(
    "/v1/designs/{design_id}/confirmation",
    tags=["designs"],
    response_model=Confirmation,
    responses={200: etag_response()[200], **problems(404, 409, 501, 504)},
    summary="A design's certificate to 25 digits",
)
async def get_confirmation(request: Request, design_id: str, parts: Parts) -> Response:
    """Every line of the certificate in ball arithmetic, by other formulas; in tenths of a second.

    Needs the optional part `exact` on the workers; without it the answer is 501.
    """
    jobs = parts.jobs[DESIGNS.path]
    row = await jobs.find_done(design_id, parts.owner)
    tag = tag_of(row.etag or "", "confirmation", "json", "")
    known = not_modified(request, tag)
    if known is not None:
        return known
    design = await jobs.body(row)
    if not json.loads(design)["motion"]:
        raise ProblemType.NOTHING_FITS(NO_CAM)
    confirmation = await make_in_worker(request, parts, partial(confirm_design, design))
    return Response(confirmation, 200, {"ETag": f'"{tag}"'}, "application/json")


@router.delete(
    "/v1/designs/{design_id}",
    tags=["designs"],
    status_code=204,
    responses=problems(404, 409),
    summary="Delete a design",
)
async def delete_design(design_id: str, parts: Parts) -> None:
    """A design being worked on is stopped; a finished one is discarded.

    One that came out of a sweep is part of the sweep's result and goes with that: 409 names it.
    Where the same design was also requested by itself, that one is deleted, and the sweep keeps its
    own.
    """
    jobs = parts.jobs[DESIGNS.path]
    row = await jobs.answers.find(design_id, parts.owner)
    if await jobs.dismiss(design_id, parts.owner):
        if row is not None and row.body is not None:
            proof = PROOFS.id_of(proof_question(row, row.body))
            await parts.jobs[PROOFS.path].dismiss(proof, parts.owner)
        return
    holder = await parts.sweeps.store.holder(design_id, parts.owner)
    if holder is None:
        raise jobs.unknown(design_id)
    sweep, number = holder
    raise ProblemType.PART_OF_SWEEP(
        f"Design {design_id} is item {number} of sweep {sweep}, and goes with it: "
        f"DELETE {sweep_path(sweep)} discards both."
    )


async def _get_report(
    request: Request,
    design_id: str,
    parts: Parts,
    theme: Annotated[Colours, Query()] = "auto",
    sensitivities: Annotated[
        bool, Query(description="Say what each limit costs too: a few solves more.")
    ] = False,
) -> Response:
    row = await parts.jobs[DESIGNS.path].find_done(design_id, parts.owner)
    costs = None
    if sensitivities:
        costs = Sensitivities.model_validate_json(await _sensitivities(parts, row))
    report = report_with(PROFILE_FORMATS, MOTION_FORMATS, costs)
    made_by = "with sensitivities" if costs else ""
    file = ResourceFile(report, write_design, REPORT, made_by=made_by)
    return await send_file(request, parts, DESIGNS, file, row, PictureOptions(theme))


add_file_route(
    router,
    DESIGNS,
    ResourceFile(PICTURES[REPORT], write_design, REPORT),
    _get_report,
    may_lack=True,
)
