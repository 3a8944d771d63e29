"""/v1/analyses and /v1/profile-analyses: what a given or a measured cam does."""

from __future__ import annotations

from functools import partial

from service.resources.resource import Resource, file_of
from service.resources.views import AnalysisPage, ProfileAnalysisPage, Verdict
from service.wire.errors import ProblemType
from service.wire.links import analysis_links
from service.workers.tasks import analyse_cam, analyse_profile, analysis_picture
from synthesis.design.analysis import Analysis
from synthesis.design.identity import question_id
from synthesis.exporters import DRAWINGS
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.measured import MeasuredCam, ProfileAnalysis

ANALYSES = Resource(
    path="/v1/analyses",
    tag="analyses",
    noun="analysis",
    plural="analyses",
    id_name="analysis_id",
    spec=DesignSpec,
    answer=Analysis,
    page=AnalysisPage,
    examples="analyses",
    id_of=lambda spec: question_id(spec, "analysis"),
    task=analyse_cam,
    links=lambda id, _: analysis_links(id),
    unknown=ProblemType.UNKNOWN_ANALYSIS,
    title="Analyse a given cam",
    text="""Extremes of all curves, each limit with its margin, jumps, undercut, and what helps.

    The laws, the base radius and the offset must be given; what is left free is a problem (422).
    A limit that is broken is a result, not an error: `holds` is false, `violated` names it,
    `extremes` says by how much and where, `remedy` which size would help. The same spec gives the
    same bytes. Its pictures and its report are at `/v1/analyses/{id}/motion.svg`, `contact.svg`, …;
    for files of points, send the same spec to `POST /v1/designs`.
    """,
    answer_text="As `POST /v1/analyses` answered, or would have without `respond-async`.",
    status=Verdict,
    files=tuple(
        file_of(
            exporter, name, f"analysis_{name.replace('.', '_')}", partial(analysis_picture, name),
            title=f"{exporter.title}, of an analysis", purpose="", in_worker=True,
        )
        for name, exporter in DRAWINGS.items()
    ),
    marks_broken_limits=True,
)  # fmt: skip
PROFILE_ANALYSES = Resource(
    path="/v1/profile-analyses",
    tag="analyses",
    noun="profile analysis",
    plural="profile analyses",
    id_name="analysis_id",
    spec=MeasuredCam,
    answer=ProfileAnalysis,
    page=ProfileAnalysisPage,
    examples="profile-analyses",
    id_of=lambda cam: question_id(cam, "profile analysis"),
    task=analyse_profile,
    links=lambda id, _: {"self": f"/v1/profile-analyses/{id}"},
    unknown=ProblemType.UNKNOWN_ANALYSIS,
    title="Read the motion back from a measured profile",
    text="""Displacement, velocity, acceleration, jerk and pressure angle that a real cam gives.

    The profile is smoothed as far as the points' own scatter and the tolerance allow; then the
    follower rides on it, held off by whatever stands out farthest. `peaks` says what the tolerance
    may hide of each derivative, `unreached_hollows` names the hollows that are too narrow
    for the roller, `contact_off_face` where contact leaves a flat face. Points that are no closed
    curve round the cam's axis are a problem (422) that names the place.
    """,
    answer_text="As `POST /v1/profile-analyses` answered, or would have without `respond-async`.",
    budget_of=lambda _: None,
)
