"""/v1/designs: ask for a cam, look at it, list them, forget it."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from service.contract.documentation import problems, spec_body, tagged
from service.resources.views import DesignPage
from service.routes.collection import WAITING, Kept, Said, declare
from service.routes.kept import KnownTag, WithStatus, done, unknown
from service.state import Parts
from service.sweeps.views import at
from service.wire.errors import PartOfSweep
from service.wire.etag import tag_of, unchanged
from service.workers.solve import priced
from synthesis.design import Design
from synthesis.findings import Sensitivities

router = APIRouter(prefix="/v1/designs", tags=["designs"])

CREATE = Said(
    "Synthesise a cam",
    """Picks base radius, offset and spline laws together and proves that every limit holds.

    Infeasible is a result (status `infeasible`, with the conflict), not an error. The same spec
    gives the same id and the same bytes.
    """,
)
declare(
    router,
    Kept(
        jobs=lambda parts: parts.designs,
        one="design",
        many="designs",
        id="design_id",
        found=Design,
        page=DesignPage,
        on_page="Designs on a page.",
        body=spec_body(),
        status=WithStatus,
    ),
    create=CREATE,
    list="List designs",
    get=Said(
        "A design",
        f"Dimensions, motion, extremes, certificate, report and links.\n\n{WAITING}",
    ),
    delete=None,  # see below: it may be part of a sweep
)


@router.get(
    "/{design_id}/sensitivities",
    response_model=Sensitivities,
    responses={**tagged(), **problems(404, 409, 500, 503, 504)},
    summary="What each limit costs",
)
async def get_design_sensitivities(
    request: Request, design_id: str, parts: Parts, if_none_match: KnownTag = None
) -> Response:
    """How the objective changes with every limit, range, window and point, to first order.

    In the limit's own units, as in: 1 deg more pressure angle makes the base radius 0.8 mm smaller.
    For every follower and objective, curvature included: multipliers of the cone program, or of the
    local optimum with every limit in it, each confirmed by seeking that again with the number a
    little larger and smaller. Where the two sides differ, both are told; what is not confirmed is
    listed as such, and what was not reached in time.
    """
    row, design = await done(parts.designs, design_id)
    tag = tag_of(row.etag or "", "sensitivities")
    known = unchanged(request, tag)
    if known is not None:
        return known
    budget_s = parts.settings.time_budget_s
    body = await parts.engine.run(priced, design, budget_s, budget_s=budget_s)
    return Response(body, 200, {"ETag": f'"{tag}"'}, "application/json")


@router.delete(
    "/{design_id}", status_code=204, responses=problems(404, 409), summary="Forget a design"
)
async def delete_design(design_id: str, parts: Parts) -> None:
    """A design being worked on is stopped; a finished one is discarded.

    One that came out of a sweep is part of the sweep's result and goes with that: 409 names it.
    Where the same design had been asked for by itself before, that is forgotten, and the sweep
    keeps its own.
    """
    if await parts.designs.dismiss(design_id):
        return
    holder = await parts.sweeps.store.holder(design_id)
    if holder is None:
        raise unknown(parts.designs.kind, design_id)
    sweep, number = holder
    raise PartOfSweep(
        f"Design {design_id} is item {number} of sweep {sweep}, and goes with it: "
        f"DELETE {at(sweep)} discards both."
    )
