"""/v1/profile-analyses: measured points of a profile back to motion."""

from __future__ import annotations

from fastapi import APIRouter

from service.contract.documentation import spec_body
from service.contract.examples import PROFILE_ANALYSES
from service.resources.views import ProfileAnalysisPage
from service.routes.collection import STOPPED, WAITING, Kept, Said, declare
from synthesis.measured import ProfileAnalysis

router = APIRouter(prefix="/v1/profile-analyses", tags=["analyses"])

CREATE = Said(
    "Read the motion back from a measured profile",
    """Displacement, velocity, acceleration, jerk and pressure angle that a real cam gives.

    The profile is smoothed as far as the points' own scatter and the tolerance allow; then the
    follower rides on it, held off by whatever stands out farthest. `peaks` says what the tolerance
    may hide of each derivative, `not_touched` names the hollows that are too narrow for the roller,
    `off_face` where contact leaves a flat face. Points that are no closed curve round the cam's
    axis are a problem (422) that names the place.
    """,
)
declare(
    router,
    Kept(
        jobs=lambda parts: parts.profile_analyses,
        one="profile_analysis",
        many="profile_analyses",
        id="analysis_id",
        found=ProfileAnalysis,
        page=ProfileAnalysisPage,
        on_page="Profiles on a page.",
        body=spec_body(PROFILE_ANALYSES, "MeasuredCam"),
    ),
    create=CREATE,
    list="List profiles that were read back",
    get=Said(
        "A profile that was read back",
        "As `POST /v1/profile-analyses` answered, or would have without `respond-async`.\n\n"
        + WAITING,
    ),
    delete=Said("Forget a profile that was read back", f"One {STOPPED}"),
)
