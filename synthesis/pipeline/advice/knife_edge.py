"""Followers that touch their cam with an edge."""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.pipeline.advice.rule import Finding, Rule
from synthesis.pipeline.advice.subject import Subject


def _find(subject: Subject) -> Iterator[Finding]:
    edges = (flank.roller == 0.0 and made.sliding_speed_mm_per_s is None
             for flank, made in subject.flanks)  # fmt: skip
    if any(edges):  # no roller, and no face that slides
        yield Finding(
            "caution", "follower/roller_radius_mm",
            "The follower touches its cam with a knife edge, which wears at once: no edge keeps a "
            "radius of 0.",
            "Give the radius of a roller, or that of a rounded tip (1 to 2 mm are usual).",
        )  # fmt: skip


RULE = Rule(
    code="knife_edge",
    thresholds="caution: a roller radius of 0.",
    reason="All of the force is on an edge that slides. What is drawn as an edge is ground to a "
    "radius of 1 to 2 mm, and the cam has to be made for it.",
    source="Sankyo's glossary of cams: knife-edged followers wear easily, and are dulled by 1 to "
    "2 mm in practice.",
    checked="Opened, and a course of machine theory that says the same of wear.",
    silenced_by="nothing: another radius is another cam",
    find=_find,
)
