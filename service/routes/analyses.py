"""/v1/analyses: what a cam does that is given in full."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from service.contract.documentation import spec_body
from service.contract.examples import ANALYSES
from service.resources.views import AnalysisPage, Verdict
from service.routes.collection import STOPPED, WAITING, Kept, Said, declare
from synthesis.findings import Analysis

router = APIRouter(prefix="/v1/analyses", tags=["analyses"])

CREATE = Said(
    "Analyse a given cam",
    """Extremes of every curve, every limit with its margin, jumps, undercut, and what mends it.

    The laws, the base radius and the offset must be given; what is left free is a problem (422).
    A limit that is broken is a result, not an error: `holds` is false, `broken` names it,
    `extremes` says by how much and where, `mend` which size would help. The same spec gives the
    same bytes. Its pictures and its report are at `/v1/analyses/{id}/motion.svg`, `contact.svg`, …;
    for files of points, send the same spec to `POST /v1/designs`.
    """,
)
declare(
    router,
    Kept(
        jobs=lambda parts: parts.analyses,
        one="analysis",
        many="analyses",
        id="analysis_id",
        found=Analysis,
        page=AnalysisPage,
        on_page="Analyses on a page.",
        body=spec_body(ANALYSES),
        status=Annotated[Verdict | None, Query(description="Only those with this result.")],
    ),
    create=CREATE,
    list="List analyses",
    get=Said(
        "An analysis",
        "As `POST /v1/analyses` answered, or would have without `respond-async`.\n\n" + WAITING,
    ),
    delete=Said("Forget an analysis", f"An analysis {STOPPED}"),
)
