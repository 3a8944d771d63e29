"""Design: what is delivered. It is the response body; files are made from it alone."""

from __future__ import annotations

import hashlib
import json
from functools import cached_property
from importlib.metadata import version
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from synthesis.motion import Motion, Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.spec import DesignSpec

Status = Literal["optimal", "feasible", "infeasible"]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SplineCurve(_Part):
    """A B-spline in normalised form: x = (θ − start)/angle in [0, 1], g(x) from 0 to 1.

    s = s_start + (s_end − s_start) g(x). Knots are without repetition; both ends are clamped.
    """

    degree: int
    knots: list[float]
    coefficients: list[float]


class SegmentMotion(_Part):
    """One segment of the motion as it came out."""

    kind: Literal["rise", "dwell", "return"]
    start_deg: float
    angle_deg: float
    s_start_mm: Annotated[float, Field(description="Measured from the lowest position.")]
    s_end_mm: float
    law: Annotated[str, Field(description="Name of the law; `spline` where it was chosen here.")]
    spline: SplineCurve | None = None


class Extreme(_Part):
    """One limit on the finished cam: how far it is used, where, and how that is known."""

    limit: str
    value: Annotated[float | None, Field(description="Extreme over all cam angles; null: none.")]
    unit: str
    angle_deg: Annotated[float, Field(description="Cam angle where the extreme occurs.")]
    bound: Annotated[float | None, Field(description="What the spec allows.")]
    margin: Annotated[
        float | None, Field(description="Distance to the bound, negative where it is broken.")
    ]
    width: Annotated[
        float, Field(description="Width of the proven enclosure of the extreme, same unit.")
    ]
    holds: Annotated[bool, Field(description="Margin not below the enclosure's width.")]
    evidence: Annotated[str, Field(description="How the extreme was enclosed.")]
    field: Annotated[str, Field(description="Field of the spec that sets the bound.")]


class Proof(_Part):
    """How far one objective is from the best possible."""

    objective: Annotated[str, Field(description="Name of the objective's value, with its unit.")]
    value: float | None
    lower_bound: Annotated[
        float | None, Field(description="No cam of the family in bound_over is better than this.")
    ]
    bound_over: Annotated[str, Field(description="The family of cams that the bound covers.")]
    gap: Annotated[float | None, Field(description="(value − lower_bound) / value.")]


class Certificate(Proof):
    """What was proven of the answer, for the first objective and in ``also`` for the others."""

    certified: Annotated[bool, Field(description="Every limit holds at every cam angle.")]
    also: Annotated[
        list[Proof],
        Field(
            description="Later objectives of an ordered list; their bounds hold for cams that "
            "keep the earlier ones."
        ),
    ] = []


class StageReport(_Part):
    """One stage of the ladder: what was modelled and what it cost."""

    stage: str
    model: str
    solver: str
    unknowns: int
    rows: int
    iterations: int
    seconds: float
    status: str
    note: str = ""


class Report(_Part):
    """Stage by stage, and the whole."""

    stages: list[StageReport]
    seconds: float


class Relaxation(_Part):
    """The least change of one limit, the others kept, that would make the scene possible."""

    limit: str
    field: str
    unit: str
    asked: float
    needed: Annotated[
        float | None,
        Field(description="Least sufficient value; null where this limit alone cannot help."),
    ]
    note: str = ""


class Conflict(_Part):
    """Why nothing fits, and what would."""

    limits: Annotated[list[str], Field(description="The limits that cannot hold together.")]
    relaxations: list[Relaxation]
    evidence: str


class Design(_Part):
    """The answer to a DesignSpec."""

    id: str
    name: str
    engine_version: str
    status: Status
    rotation: Literal["ccw", "cw"]
    speed_rpm: float
    follower: str
    dimensions: Annotated[
        dict[str, float], Field(description="Base radius, prime radius, offset, … in mm.")
    ]
    size: Annotated[
        list[float], Field(description="The follower's size variables; see /v1/followers.")
    ]
    objectives: Annotated[dict[str, float], Field(description="Value of every objective asked.")]
    motion: list[SegmentMotion]
    extremes: list[Extreme]
    certificate: Certificate
    conflict: Conflict | None = None
    report: Report
    spec: DesignSpec
    links: dict[str, str] = {}

    @cached_property
    def curve(self) -> Motion:
        """The motion, rebuilt to the last bit from the spec and the spline coefficients."""
        settled: list[Stretch] = []
        for stretch, segment in zip(self.spec.stretches(), self.motion, strict=True):
            if segment.spline is None:
                settled.append(stretch)
                continue
            space = SplineSpace(segment.spline.degree, np.array(segment.spline.knots))
            settled.append(stretch.with_law(space.curve(np.array(segment.spline.coefficients))))
        return Motion.of(settled)


def engine_version() -> str:
    """Version of the installed distribution."""
    return version("camwright")


def design_id(spec: DesignSpec) -> str:
    """Hash of the spec and the engine's version: the same question has the same name."""
    body = json.dumps(spec.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(f"{engine_version()}\n{body}".encode()).hexdigest()[:32]
