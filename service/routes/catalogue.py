"""/v1/motion-laws, /v1/followers, /v1/formats, /v1/limits: what there is, read from the core."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fastapi import APIRouter
from pydantic import BaseModel, Field

from service.state import Parts
from service.workers.tasks import DESIGN_FORMATS
from synthesis.catalogue.followers import FOLLOWERS
from synthesis.catalogue.laws import LAWS, SplineLaw
from synthesis.catalogue.laws.base import TASKS, Characteristics, EndKinds, characteristics
from synthesis.catalogue.limits import LIMITS
from synthesis.catalogue.objectives import OBJECTIVES
from synthesis.exporters import PICTURES, form
from synthesis.exporters.exporter import FileFormat
from synthesis.exporters.options import MAX_POINTS, MAX_POINTS_PER_DEGREE, MIN_TOLERANCE_UM
from synthesis.machines.spatial.files import FORMATS as SPATIAL_FORMATS
from synthesis.spec.cam_set import MAX_CAMS
from synthesis.spec.design_spec import MAX_SEGMENTS

router = APIRouter(prefix="/v1", tags=["catalogue"])


class Entry(BaseModel):
    """One member of a registry."""

    kind: str = Field(description="Its name in a spec.")
    title: str = Field(description="Its name for people.")
    description: str = Field(description="What it is, in a sentence or two.")
    json_schema: dict[str, Any] = Field(description="Its fields, as JSON Schema.")


class MotionLawEntry(Entry):
    """A motion law."""

    source: str = Field(description="Where its formula is from.")
    ends: EndKinds | None = Field(
        description="VDI 2143: R rests, U turns back without resting; null: as the spec is."
    )
    tasks: list[str] = Field(
        description="Tasks of VDI 2143 that it can serve on a rise, start and end: R rests, "
        "G runs at constant velocity (G-G: equal ones), U turns back, B moves; none where "
        "velocity or acceleration jump at its ends."
    )
    characteristics: Characteristics | None = Field(
        description="Peaks for unit lift and angle; null: chosen."
    )


class FollowerEntry(Entry):
    """A follower family."""

    size_names: list[str] = Field(description="The size variables that are solved for.")
    size_charts: list[list[str]] = Field(
        description="Every set of size variables that is in use: the first of them, or "
        "another where other dimensions are given (an arm's pivot fixed, or free)."
    )


class FormatEntry(BaseModel):
    """A file format."""

    name: str = Field(description="Last part of the path, as in profile.csv.")
    title: str = Field(description="Its name for people.")
    media_type: str = Field(description="Content-Type of the file.")
    extension: str = Field(description="Of the file's name, with its dot.")
    purpose: str = Field(description="What it is for; empty where the title says it.")
    json_schema: dict[str, Any] = Field(description="Its query parameters, as JSON Schema.")


class Formats(BaseModel):
    """The files that a finished design can be had as."""

    profile: list[FormatEntry] = Field(description="Of the cam's curve.")
    motion: list[FormatEntry] = Field(description="Of the follower's motion.")
    pictures: list[FormatEntry] = Field(
        description="Pictures and pages; the name is the path's last part as it stands."
    )
    solid: list[FormatEntry] = Field(description="Of the cam as a body.")
    spatial: list[FormatEntry] = Field(
        description="Of spatial cams; the name is the path's last part as it stands."
    )


class ServerLimits(BaseModel):
    """What this server allows."""

    max_body_bytes: int = Field(description="Largest request body [bytes].")
    time_budget_s: float = Field(description="Time for a design that asks for none [s].")
    max_time_budget_s: float = Field(description="Most that a design may have [s].")
    max_cams: int = Field(description="Cams on one shaft.")
    max_segments: int = Field(description="Segments in a program.")
    max_points_per_degree: float = Field(description="Density of exported points.")
    max_points: int = Field(description="Points of a file.")
    min_tolerance_um: float = Field(description="Finest chord tolerance [µm].")
    max_waiting: int = Field(description="Designs that may wait for a worker.")
    max_sweep_items: int = Field(description="Items that a sweep may have.")
    max_sweeps: int = Field(description="Sweeps that may be under way.")
    workers: int = Field(description="Designs worked on at the same time.")


class Limits(BaseModel):
    """Limits and objectives that a spec may name, and what this server allows."""

    limits: list[Entry] = Field(description="What may not be exceeded.")
    objectives: list[Entry] = Field(description="What may be made small.")
    server: ServerLimits = Field(description="What this server allows.")


@router.get("/motion-laws", summary="Motion laws")
def list_motion_laws() -> list[MotionLawEntry]:
    """Every law that a rise or return may name; `spline` is found by the service."""
    named = [
        MotionLawEntry(
            **_entry(type(law), law.entry.title, kind),
            source=law.entry.source,
            ends=law.ends,
            tasks=list(law.tasks),
            characteristics=characteristics(law),
        )
        for kind, law in LAWS.items()
    ]
    spline = _entry(SplineLaw, "Spline, chosen by the service")
    whole = MotionLawEntry(**spline, source="", ends=None, tasks=list(TASKS), characteristics=None)
    return [*named, whole]


@router.get("/followers", summary="Follower families")
async def list_followers() -> list[FollowerEntry]:
    """Every follower family that a spec may name."""
    return [
        FollowerEntry(
            **_entry(family, family.title),
            size_names=list(family.size_charts[0]),
            size_charts=[list(names) for names in family.size_charts],
        )
        for family in FOLLOWERS
    ]


@router.get("/formats", summary="File formats")
async def list_formats() -> Formats:
    """The files that a finished design can be had as."""
    formats: dict[str, Mapping[str, FileFormat[Any, Any]]]
    formats = {**DESIGN_FORMATS, "pictures": PICTURES, "spatial": SPATIAL_FORMATS}
    return Formats.model_validate(
        {
            part: [
                {**vars(each), "json_schema": form(each.options).model_json_schema()}
                for each in registry.values()
            ]
            for part, registry in formats.items()
        }
    )


@router.get("/limits", summary="Limits and objectives, and what this server allows")
async def list_limits(parts: Parts) -> Limits:
    """Every limit and objective that a spec may name, and what this server allows."""
    # Fields of the same name as a setting; the number of workers may be that of a remote scheduler.
    known: dict[str, Any] = parts.settings.model_dump() | {
        "max_cams": MAX_CAMS,
        "max_segments": MAX_SEGMENTS,
        "max_points_per_degree": MAX_POINTS_PER_DEGREE,
        "max_points": MAX_POINTS,
        "min_tolerance_um": MIN_TOLERANCE_UM,
        "workers": parts.engine.slots,
    }
    return Limits(
        limits=[Entry(**_entry(limit, limit.title)) for limit in LIMITS],
        objectives=[Entry(**_entry(each, each.title)) for each in OBJECTIVES],
        server=ServerLimits.model_validate(known),
    )


def _entry(member: type[BaseModel], title: str, kind: str | None = None) -> dict[str, Any]:
    description = (member.__doc__ or "").strip().partition("\n\n")[0].replace("\n    ", " ")
    schema = member.model_json_schema()
    kind = kind or member.model_fields["kind"].default
    return {"kind": kind, "title": title, "description": description, "json_schema": schema}
