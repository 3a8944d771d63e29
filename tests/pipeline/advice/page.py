"""The page of warnings, made of the rules: ``python -m tests.pipeline.advice.page``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from synthesis.machines.spatial.advice import RULES as SPATIAL_RULES
from synthesis.pipeline.advice import RULES
from synthesis.pipeline.advice.rule import Rule

TARGET = Path(__file__).resolve().parents[3] / "docs" / "warnings.md"
HEAD = """# Warnings

A certified cam keeps every limit that was asked for, and yet nobody may want to build it. Every
design has `warnings`: what an engineer would say of the cam by the rules of the field, the most
severe first, and beside `status` the `severity` of the worst.

| severity | meaning |
|---|---|
| `note` | unusual: look at it |
| `caution` | few would build it |
| `stop` | it cannot work; reports, terminal and studio write STOP beside the status |

A warning has a `code` (the rule), `severity`, the `field` of the spec where it is mended, a
`sentence` with the values, a `remedy` and the `source` of the rule. A rule is silent where the spec
sets on purpose what it would warn of. Warnings change neither the cam nor its status: they speak of
what the limits do not say. Where no limit encloses the pressure angle it is sampled, at every
degree and at both sides of every end of a piece of the motion; all else is taken from the
certificate, the forces and the [summary](datasheet.md).

"""
SPATIAL = """## Spatial cams

Cylindrical and globoidal cams have `warnings` and `severity` too, from what was measured on the
finished cam (`extremes`). The field's rules for hubs, springs and loads need what their specs do
not have. The rules are in `synthesis/machines/spatial/advice.py`.

"""
FOOT = """
This page is written by `python -m tests.pipeline.advice.page`; a test holds it to the rules. A new
rule is a file in `synthesis/pipeline/advice` and a line in its `RULES`. How often they speak on
everyday cams: `python -m tests.hard.everyday`, and `python -m tests.hard.trades` of another author.
"""


def page() -> str:
    """The whole page."""
    plane = [f"## {rule.code}\n\n{_table(rule)}" for rule in RULES]
    spatial = [f"### {rule.code}\n\n{_table(rule)}" for rule in SPATIAL_RULES]
    return "".join([HEAD, *plane, SPATIAL, *spatial]).rstrip("\n") + "\n" + FOOT


def _table(rule: Rule[Any]) -> str:
    return (
        f"| | |\n|---|---|\n| warns | {rule.thresholds} |\n"
        f"| reason | {rule.reason} |\n| source | {rule.source} |\n"
        f"| checked | {rule.checked} |\n| silenced by | {rule.silenced_by} |\n\n"
    )


if __name__ == "__main__":
    TARGET.write_text(page(), "utf-8")
