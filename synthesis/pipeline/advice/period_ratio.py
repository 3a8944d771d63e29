"""The train's natural period against the time of a move."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from synthesis.catalogue.limits.motion import ResidualVibration
from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject
from synthesis.units import rad_per_s

LEAST: Final = 3.0  # time of a move over the natural period


def _find(subject: Subject) -> Iterator[Finding]:
    moves = [s for s in subject.spec.placed_segments() if s.kind != "dwell" and s.angle > 0.0]
    for limit in subject.limits("residual_vibration"):
        assert isinstance(limit, ResidualVibration)
        shortest = min(moves, key=lambda segment: segment.angle)
        ratio = shortest.angle / rad_per_s(subject.spec.speed_rpm) * limit.natural_frequency_hz
        if ratio < LEAST:
            yield Finding(
                "note", "limits/residual_vibration/natural_frequency_hz",
                f"Segment {shortest.index} lasts {number(ratio)} natural periods of the train: "
                "during the move its output does not follow the cam. The limit bounds what is "
                "left after the move only.",
                "Make the train stiffer or lighter, or give the move more angle; see the response "
                "of the train (train-responses).",
            )  # fmt: skip


RULE = Rule(
    code="period_ratio",
    thresholds="note: the shortest move below 3 natural periods.",
    reason="Of an undamped train of one mass the output's peak acceleration is 1.5 times the "
    "cam's with a cycloidal, 1.65 with a 3-4-5 and 1.84 with a modified sine move of 3 natural "
    "periods; of 10 periods it is 1.1 to 1.15.",
    source="Rule of this program, from the response of a train of one mass; the period ratio λ is "
    "that of the Cam Design Handbook (Rothbart, ed., 2004), ch. 13.",
    checked="The page that defines λ (p. 417) opened, and p. 368: the natural frequency as high "
    "as possible; none has a threshold. The ratios are computed by a test "
    "(tests/pipeline/advice/test_period_ratio.py).",
    silenced_by="nothing: the limit residual_vibration, which tells the frequency, bounds another "
    "thing",
    find=_find,
)
