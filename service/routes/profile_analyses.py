"""/v1/profile-analyses: measured points of a profile back to motion. Nothing is kept."""

from __future__ import annotations

import hashlib

from fastapi import APIRouter, Request, Response

from service.body import read_body
from service.documentation import problems, spec_body, tagged
from service.examples import PROFILE_ANALYSES
from service.solve import read_back
from service.state import Parts
from synthesis.measured import MeasuredCam, ProfileAnalysis

router = APIRouter(prefix="/v1/profile-analyses", tags=["analyses"])


@router.post(
    "",
    response_model=ProfileAnalysis,
    responses={200: tagged()[200], **problems(400, 413, 415, 422, 429, 500, 503, 504)},
    openapi_extra=spec_body(PROFILE_ANALYSES, "MeasuredCam"),
    summary="Read the motion back from a measured profile",
)
async def create_profile_analysis(request: Request, parts: Parts) -> Response:
    """Displacement, velocity, acceleration, jerk and pressure angle that a real cam gives.

    The profile is smoothed as far as the points' own scatter and the tolerance allow; then the
    follower rides on it, held off by whatever stands out farthest. `peaks` says what the tolerance
    may hide of each derivative, `not_touched` names the hollows that are too narrow for the roller,
    `off_face` where contact leaves a flat face. Points that are no closed curve round the cam's
    axis are a problem (422) that names the place.
    """
    cam = await read_body(request, MeasuredCam)
    parts.engine.admit()
    found = await parts.engine.solve(
        cam.model_dump_json().encode(), parts.settings.budget_s(None), read_back
    )
    tag = hashlib.sha256(found.design).hexdigest()[:32]
    return Response(found.design, 200, {"ETag": f'"{tag}"'}, "application/json")
