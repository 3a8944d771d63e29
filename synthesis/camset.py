"""CamSet: several cams on one shaft as they are delivered. It is a response body."""

from __future__ import annotations

from collections import Counter

from pydantic import Field

from synthesis.camset_spec import CamOnShaft, CamSetSpec, within_turn
from synthesis.design import Design, Part, Status, engine_version, question_id, told
from synthesis.fields import Rotation

WORST_FIRST: tuple[Status, ...] = ("infeasible", "feasible", "optimal")


class MountedCam(Part):
    """One cam, and how it sits on the shaft."""

    name: str = told("Name of the cam; where several share one, each with its number behind it.")
    phase_deg: float = told("Shaft angle at which its program starts.")
    axial_mm: float = told("Position along the shaft.")
    follower_direction_deg: float = told("Direction of its follower, counter-clockwise from x.")
    turn_deg: float = told(
        "Angle by which the cam is turned on the shaft against its own design's frame, "
        "counter-clockwise positive seen with z towards the viewer, the shaft at shaft angle 0."
    )
    mark_deg: float = told(
        "Direction, in the shaft's frame, of the cam's mark: the y axis of its own frame, which "
        "lies along the follower when the program starts."
    )
    keyway_deg: float = told(
        "Direction, in the cam's own frame, of the shaft's y axis: where to cut the keyway if all "
        "cams sit on one straight key."
    )
    design: Design = told("The cam's design, in its own frame.")

    @property
    def has_cam(self) -> bool:
        """Whether there is a cam to draw."""
        return bool(self.design.motion)


class TimingEvent(Part):
    """One segment of a cam ends and the next one starts."""

    shaft_deg: float = told("Shaft angle, from 0 to below 360.")
    cam: int = told("Position of the cam in `cams`, from 0.")
    ends: str = told("What the follower did until here: rise, dwell, return, …")
    starts: str = told("What it does from here on.")


class TimingArc(Part):
    """A part of the turn in which the same followers move."""

    start_deg: float = told("Shaft angle where it starts.")
    angle_deg: float = told("How far it extends.")
    moving: list[int] = told(
        "Positions of the cams whose followers move; two or more: their motions overlap."
    )


class Timing(Part):
    """What happens when, over one turn of the shaft."""

    events: list[TimingEvent] = told("In the order of shaft angle, then of `cams`.")
    arcs: list[TimingArc] = told("The whole turn, split where a follower starts or stops moving.")


class CamSet(Part):
    """The answer to a CamSetSpec."""

    id: str = told("Hash of the spec and the engine's version.")
    name: str = told("Name from the spec.")
    engine_version: str = told("Version of Camwright that made it.")
    status: Status = told("The worst of the cams': infeasible before feasible before optimal.")
    rotation: Rotation = told("Sense in which the shaft turns.")
    speed_rpm: float = told("Speed of the shaft.")
    cams: list[MountedCam] = told("The cams in the order of the spec.")
    timing: Timing = told("What happens when. Cams for which nothing fits take no part.")
    seconds: float = told("Wall time of the whole set in the core.")
    spec: CamSetSpec = told("The question.")
    links: dict[str, str] = Field({}, description="Where to find its files.")

    @property
    def has_cams(self) -> bool:
        """Whether there is any cam to draw."""
        return any(cam.has_cam for cam in self.cams)


def mounted(position: int, cam: CamOnShaft, design: Design) -> MountedCam:
    """A finished design on its shaft; ``position`` names a cam that has no name."""
    turn = cam.turn_deg(design.rotation)
    return MountedCam(
        name=cam.name.strip() or design.name.strip() or f"cam {position + 1}",
        phase_deg=cam.phase_deg,
        axial_mm=cam.axial_mm,
        follower_direction_deg=cam.follower_direction_deg,
        turn_deg=turn,
        mark_deg=within_turn(90.0 + turn),
        keyway_deg=within_turn(90.0 - turn),
        design=design,
    )


def told_apart(cams: list[MountedCam]) -> list[MountedCam]:
    """The same cams; those that share a name bear their number behind it."""
    shared = [name for name, count in Counter(cam.name for cam in cams).items() if count > 1]
    if not shared:
        return cams
    numbered = [
        cam.model_copy(update={"name": f"{cam.name} ({number})"}) if cam.name in shared else cam
        for number, cam in enumerate(cams, start=1)
    ]
    return told_apart(numbered)  # a name that was given may look like that already


def assembled(spec: CamSetSpec, cams: list[MountedCam], timing: Timing, seconds: float) -> CamSet:
    """The set as it is delivered."""
    return CamSet(
        id=set_id(spec),
        name=spec.name,
        engine_version=engine_version(),
        status=min((cam.design.status for cam in cams), key=WORST_FIRST.index),
        rotation=spec.rotation,
        speed_rpm=spec.speed_rpm,
        cams=told_apart(cams),
        timing=timing,
        seconds=seconds,
        spec=spec,
    )


def set_id(spec: CamSetSpec) -> str:
    """The set's id on this engine."""
    return question_id(spec, "cam set")
