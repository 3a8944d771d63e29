"""CamSet: several cams on one shaft as they are delivered. It is a response body."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, Rotation, doc
from synthesis.design.design import Design, Status
from synthesis.design.identity import engine_version, question_id
from synthesis.spec.cam_set import CamOnShaft, CamSetSpec, wrap_turn

WORST_FIRST: tuple[Status, ...] = ("infeasible", "feasible", "optimal")


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
    status: Status = doc("The worst of the cams': infeasible before feasible before optimal.")
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


@dataclass(frozen=True)
class CamSchedule:
    """The segments of one cam in the order of shaft angle.

    Attributes:
        cam: position of the cam.
        starts: shaft angles where segments start, increasing in [0, 360) [deg].
        kinds: what the follower does from each of them to the next, round the turn.
    """

    cam: int
    starts: tuple[float, ...]
    kinds: tuple[str, ...]

    @classmethod
    def of(cls, position: int, cam: MountedCam) -> CamSchedule:
        """The schedule of a finished cam; segments without extent are left out."""
        segments = [segment for segment in cam.design.motion if segment.angle_deg > 0.0]
        placed = [(wrap_turn(s.start_deg + cam.phase_deg), s.kind) for s in segments]
        placed.sort(key=lambda each: each[0])
        return cls(position, tuple(at for at, _ in placed), tuple(kind for _, kind in placed))

    def kind_at(self, shaft_deg: float) -> str:
        """What the follower does from this shaft angle on."""
        return self.kinds[bisect_right(self.starts, shaft_deg) - 1]  # −1: over the turn's end

    def events(self) -> Iterator[TimingEvent]:
        """Every change from one segment to the next."""
        for i, (at, kind) in enumerate(zip(self.starts, self.kinds, strict=True)):
            yield TimingEvent(shaft_deg=at, cam=self.cam, ends=self.kinds[i - 1], starts=kind)


def timing_of(cams: Sequence[MountedCam]) -> Timing:
    """Events and arcs of a set; cams for which nothing fits take no part."""
    schedules = [CamSchedule.of(i, cam) for i, cam in enumerate(cams) if cam.has_cam]
    events = [event for course in schedules for event in course.events()]
    events.sort(key=lambda event: (event.shaft_deg, event.cam))
    return Timing(events=events, arcs=_arcs(schedules))


def _arcs(schedules: Sequence[CamSchedule]) -> list[TimingArc]:
    borders = sorted({at for course in schedules for at in course.starts})
    moving = [[c.cam for c in schedules if c.kind_at(at) != "dwell"] for at in borders]
    changes = [i for i in range(len(borders)) if moving[i] != moving[i - 1]]
    if not changes:
        return [TimingArc(start_deg=0.0, angle_deg=360.0, moving=moving[0] if moving else [])]
    starts = [borders[i] for i in changes]
    ends = [*starts[1:], starts[0] + 360.0]
    return [
        TimingArc(start_deg=start, angle_deg=round(end - start, 9), moving=moving[i])
        for i, start, end in zip(changes, starts, ends, strict=True)
    ]
