"""Peaks far above those of the named law that is usual for the same move."""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.design.summary import MoveSummary
from synthesis.pipeline.advice.rule import SMALL_ACCELERATION, Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

MOST_ACCELERATION, MOST_JERK = 2.0, 4.0  # times the reference law's
SMOOTHNESS = ("peak_acceleration", "peak_jerk", "rms_acceleration", "rms_jerk")  # objectives
MOST_JERK_LIMITED = 10.0  # times its jerk, where the acceleration is limited: it rises within 1 %


def _find(subject: Subject) -> Iterator[Finding]:
    if subject.limited("jerk") or subject.minimises(*SMOOTHNESS):
        return
    free = {s.index for s in subject.spec.placed_segments() if s.free is not None}
    moves = [move for move in subject.summary.moves if move.segment in free]
    worst = max(moves, key=_share, default=None)
    if worst is None or worst.reference is None:
        return
    acceleration, jerk = _times(worst)
    limited = subject.limited("acceleration")
    rough = acceleration > MOST_ACCELERATION and not limited
    if not rough and jerk <= MOST_JERK:
        return
    peaks = worst.acceleration.largest.value, worst.acceleration.smallest.value
    peak = max(subject.in_metres(abs(value)) for value in peaks)
    mild = peak <= SMALL_ACCELERATION or (limited and jerk <= MOST_JERK_LIMITED)
    usual = worst.reference.law.replace("_", " ")
    what = f"the peak acceleration is {number(acceleration)} times, the peak jerk {number(jerk)}"
    unit = subject.spec.follower.travel.unit
    yield Finding(
        "note" if mild else "caution", "limits",
        f"On segment {worst.segment} {what} times that of the {usual}, which is usual there: "
        f"{number(peak)} m/s² in place of {number(peak / acceleration)}.",
        f"Limit the jerk (limit jerk, max_{unit}_per_s3), or make rms_jerk a second objective.",
    )  # fmt: skip


def _times(move: MoveSummary) -> tuple[float, float]:
    """Peak acceleration and jerk over those of the reference law; 0 where one is infinite."""
    usual, own = move.reference, move.coefficients
    if usual is None:
        return 0.0, 0.0
    pairs = (own.Ca, usual.coefficients.Ca), (own.Cj, usual.coefficients.Cj)
    a, j = (own / usual if own is not None and usual else 0.0 for own, usual in pairs)
    return a, j


def _share(move: MoveSummary) -> float:
    acceleration, jerk = _times(move)
    return max(acceleration / MOST_ACCELERATION, jerk / MOST_JERK)


RULE = Rule(
    code="rough_motion",
    thresholds="caution: on a move whose law is chosen, the peak acceleration above 2 times, or "
    "the peak jerk above 4 times that of the reference law (`motion_summary`); note: the same "
    "where the acceleration stays below 0.98 m/s² (a tenth of the weight), and of a jerk up to "
    "10 times where the acceleration is limited.",
    reason="With nothing said of acceleration and jerk the smallest cam has a law that bends as "
    "sharply as it may; forces and vibration grow with both.",
    source="Rule of this program, from a comparison with the named law that is usual for the ends "
    "of a move (Beckhoff's list of cam laws, by the kinds of ends of VDI 2143).",
    checked="Beckhoff's list opened; the guideline was not, and nothing is taken from it. The "
    "coefficients are computed here. The factors 2 and 4 are this program's.",
    silenced_by="the limit jerk; a first objective of acceleration or jerk; the limit acceleration "
    "(its own part)",
    find=_find,
)
