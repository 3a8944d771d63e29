"""/v1/designs/{id}/confirmation: a finished design's certificate, measured a second time."""

from __future__ import annotations

import json

from fastapi import APIRouter, Request, Response

from service.contract.documentation import problems, tagged
from service.routes.kept import done
from service.state import Parts
from service.wire.errors import NothingFits
from service.wire.etag import tag_of, unchanged
from service.workers.solve import confirm
from synthesis.confirmation import Confirmation

router = APIRouter(prefix="/v1/designs/{design_id}", tags=["designs"])


@router.get(
    "/confirmation",
    response_model=Confirmation,
    responses={200: tagged()[200], **problems(404, 409, 429, 500, 501, 503, 504)},
    summary="A design's certificate to 25 digits",
)
async def get_confirmation(request: Request, design_id: str, parts: Parts) -> Response:
    """Every line of the certificate in ball arithmetic, by other formulas; in tenths of a second.

    Needs the optional part `exact` on the workers; without it the answer is 501.
    """
    row, design = await done(parts.designs, design_id)
    if not json.loads(design)["motion"]:
        raise NothingFits("No cam fits these limits: see conflict in the design for what would.")
    tag = tag_of(row.etag or "", "confirmation", "json", "")
    known = unchanged(request, tag)
    if known is not None:
        return known
    parts.engine.admit()
    found = await parts.engine.solve(design, parts.settings.budget_s(None), confirm)
    return Response(found.design, 200, {"ETag": f'"{tag}"'}, "application/json")
