"""What the followers of a set do when, in shaft angle."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from synthesis.design.cam_set import MountedCam, Timing, TimingArc, TimingEvent
from synthesis.spec.cam_set import wrap_turn


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
        """The course of a finished cam; segments without extent are left out."""
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
    courses = [CamSchedule.of(i, cam) for i, cam in enumerate(cams) if cam.has_cam]
    events = [event for course in courses for event in course.events()]
    events.sort(key=lambda event: (event.shaft_deg, event.cam))
    return Timing(events=events, arcs=_arcs(courses))


def _arcs(courses: Sequence[CamSchedule]) -> list[TimingArc]:
    borders = sorted({at for course in courses for at in course.starts})
    moving = [[c.cam for c in courses if c.kind_at(at) != "dwell"] for at in borders]
    changes = [i for i in range(len(borders)) if moving[i] != moving[i - 1]]
    if not changes:
        return [TimingArc(start_deg=0.0, angle_deg=360.0, moving=moving[0] if moving else [])]
    starts = [borders[i] for i in changes]
    ends = [*starts[1:], starts[0] + 360.0]
    return [
        TimingArc(start_deg=start, angle_deg=round(end - start, 9), moving=moving[i])
        for i, start, end in zip(changes, starts, ends, strict=True)
    ]
