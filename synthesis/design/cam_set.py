"""CamSet: several cams on one shaft as they are delivered. It is a response body."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Sequence
from operator import itemgetter

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, Rotation, doc
from synthesis.design.design import Design, Status
from synthesis.design.identity import engine_version, question_id
from synthesis.design.warnings import SEVERITIES, Severity
from synthesis.spec.cam_set import CamOnShaft, CamSetSpec, wrap_turn

START = itemgetter(0)
WORST_FIRST: tuple[Status, ...] = ("infeasible", "unsolved", "feasible", "optimal")


class MountedCam(AnswerModel):
    """One cam, and how it sits on the shaft."""

    name: str = doc("Name of the cam; where several share one, each with its number behind it.")
    phase_deg: float = doc("Shaft angle at which its program starts.")
    axial_mm: float = doc("Position along the shaft.")
    follower_direction_deg: float = doc("Direction of its follower, counter-clockwise from x.")
    turn_deg: float = doc(
        "Angle by which the cam is turned on the shaft against its own design's frame, "
        "counter-clockwise positive seen with z towards the viewer, the shaft at shaft angle 0."
    )
    mark_deg: float = doc(
        "Direction, in the shaft's frame, of the cam's mark: the y axis of its own frame, which "
        "lies along the follower when the program starts."
    )
    keyway_deg: float = doc(
        "Direction, in the cam's own frame, of the shaft's y axis: where to cut the keyway if all "
        "cams sit on one straight key."
    )
    design: Design = doc("The cam's design, in its own frame.")

    @property
    def has_cam(self) -> bool:
        """Whether there is a cam to draw."""
        return bool(self.design.motion)


class TimingEvent(AnswerModel):
    """One segment of a cam ends and the next one starts."""

    shaft_deg: float = doc("Shaft angle, from 0 to below 360.")
    cam: int = doc("Position of the cam in `cams`, from 0.")
    ends: str = doc("What the follower did until here: rise, dwell, return, …")
    starts: str = doc("What it does from here on.")


class TimingArc(AnswerModel):
    """A part of the turn in which the same followers move."""

    start_deg: float = doc("Shaft angle where it starts.")
    angle_deg: float = doc("How far it extends.")
    moving: list[int] = doc(
        "Positions of the cams whose followers move; two or more: their motions overlap."
    )


class Timing(AnswerModel):
    """What happens when, over one turn of the shaft."""

    events: list[TimingEvent] = doc("In the order of shaft angle, then of `cams`.")
    arcs: list[TimingArc] = doc("The whole turn, split where a follower starts or stops moving.")


class CamSet(AnswerModel):
    """The answer to a CamSetSpec."""

    id: str = doc("Hash of the spec and the engine's version.")
    name: str = doc("Name from the spec.")
    engine_version: str = doc("Version of Camwright that made it.")
    status: Status = doc(
        "The worst of the cams': infeasible before unsolved before feasible before optimal."
    )
    severity: Severity = Field("none", description="That of the worst warning of its cams.")
    rotation: Rotation = doc("Sense in which the shaft turns.")
    speed_rpm: float = doc("Speed of the shaft.")
    cams: list[MountedCam] = doc("The cams in the order of the spec.")
    timing: Timing = doc("What happens when. Cams for which nothing fits take no part.")
    seconds: float = doc("Wall time of the whole set in the core.")
    spec: CamSetSpec = doc("The question.")
    links: dict[str, str] = Field({}, description="Where to find its files.")

    @property
    def has_cams(self) -> bool:
        """Whether there is any cam to draw."""
        return any(cam.has_cam for cam in self.cams)


def mount(position: int, cam: CamOnShaft, design: Design) -> MountedCam:
    """A finished design on its shaft; ``position`` names a cam that has no name."""
    turn = cam.turn_deg(design.rotation)
    return MountedCam(
        name=cam.name.strip() or design.name.strip() or f"cam {position + 1}",
        phase_deg=cam.phase_deg,
        axial_mm=cam.axial_mm,
        follower_direction_deg=cam.follower_direction_deg,
        turn_deg=turn,
        mark_deg=wrap_turn(90.0 + turn),
        keyway_deg=wrap_turn(90.0 - turn),
        design=design,
    )


def number_duplicates(cams: list[MountedCam]) -> list[MountedCam]:
    """The same cams; those that share a name bear their number behind it."""
    shared = [name for name, count in Counter(cam.name for cam in cams).items() if count > 1]
    if not shared:
        return cams
    numbered = [
        cam.model_copy(update={"name": f"{cam.name} ({number})"}) if cam.name in shared else cam
        for number, cam in enumerate(cams, start=1)
    ]
    return number_duplicates(numbered)  # a name that was given may look like that already


def assemble_set(
    spec: CamSetSpec, cams: list[MountedCam], timing: Timing, seconds: float
) -> CamSet:
    """The set as it is delivered."""
    return CamSet(
        id=set_id(spec),
        name=spec.name,
        engine_version=engine_version(),
        status=min((cam.design.status for cam in cams), key=WORST_FIRST.index),
        severity=max((cam.design.severity for cam in cams), key=SEVERITIES.index),
        rotation=spec.rotation,
        speed_rpm=spec.speed_rpm,
        cams=number_duplicates(cams),
        timing=timing,
        seconds=seconds,
        spec=spec,
    )


def set_id(spec: CamSetSpec) -> str:
    """The set's id on this engine."""
    return question_id(spec, "cam set")


def timing_of(cams: Sequence[MountedCam]) -> Timing:
    """Events and arcs of a set; cams for which nothing fits take no part."""
    # Of every cam where its segments start, and what the follower does from there on.
    schedules = {
        i: sorted(
            ((wrap_turn(s.start_deg + cam.phase_deg), s.kind) for s in cam.design.motion
             if s.angle_deg > 0.0), key=START,
        )
        for i, cam in enumerate(cams)
        if cam.has_cam
    }  # fmt: skip
    events = [
        TimingEvent(shaft_deg=at, cam=i, ends=schedule[k - 1][1], starts=kind)
        for i, schedule in schedules.items()
        for k, (at, kind) in enumerate(schedule)
    ]
    events.sort(key=lambda event: (event.shaft_deg, event.cam))
    # The turn is cut wherever a segment starts; parts in which the same followers move are one arc.
    cuts = sorted({event.shaft_deg for event in events})
    moving = [
        [
            i
            for i, one in schedules.items()
            if one[bisect_right(one, at, key=START) - 1][1] != "dwell"
        ]
        for at in cuts
    ]
    changes = [k for k in range(len(cuts)) if moving[k] != moving[k - 1]]
    if not changes:
        whole = TimingArc(start_deg=0.0, angle_deg=360.0, moving=moving[0] if moving else [])
        return Timing(events=events, arcs=[whole])
    starts = [cuts[k] for k in changes]
    arcs = [
        TimingArc(start_deg=start, angle_deg=round(end - start, 9), moving=moving[k])
        for k, start, end in zip(changes, starts, [*starts[1:], starts[0] + 360.0], strict=True)
    ]
    return Timing(events=events, arcs=arcs)
