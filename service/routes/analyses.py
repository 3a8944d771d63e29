"""/v1/analyses: what a cam does that is given in full. Nothing is kept."""

from __future__ import annotations

import hashlib
from typing import Any

from fastapi import APIRouter, Request, Response

from service.body import read_body
from service.documentation import problems, spec_body, tagged
from service.examples import ANALYSES
from service.solve import analyse
from service.state import Parts
from synthesis.findings import Analysis
from synthesis.spec import DesignSpec

router = APIRouter(prefix="/v1/analyses", tags=["analyses"])
FOUND: dict[int | str, dict[str, Any]] = {200: tagged()[200]}


@router.post(
    "",
    response_model=Analysis,
    responses={**FOUND, **problems(400, 413, 415, 422, 429, 500, 503, 504)},
    openapi_extra=spec_body(ANALYSES),
    summary="Analyse a given cam",
)
async def create_analysis(request: Request, parts: Parts) -> Response:
    """Extremes of every curve, every limit with its margin, jumps, undercut, and what mends it.

    The laws, the base radius and the offset must be given; what is left free is a problem (422).
    A limit that is broken is a result, not an error: `holds` is false, `broken` names it,
    `extremes` says by how much and where, `mend` which size would help. The same spec gives the
    same bytes. For the files of such a cam, send the same spec to `POST /v1/designs`.
    """
    spec = await read_body(request, DesignSpec)
    parts.engine.admit()
    budget = parts.settings.budget_s(spec.time_budget_s)
    found = await parts.engine.solve(spec.model_dump_json().encode(), budget, analyse)
    tag = hashlib.sha256(found.design).hexdigest()[:32]
    return Response(found.design, 200, {"ETag": f'"{tag}"'}, "application/json")
