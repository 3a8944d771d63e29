"""A proof that was ended by its budget."""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.optimise.strategy.unmodelled_limits import IN_PROOF
from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

ENDED = "budget of the proof"


def _find(subject: Subject) -> Iterator[Finding]:
    design = subject.design
    gap, spec = design.certificate.gap, design.spec
    if design.status != "feasible" or gap is None or gap <= spec.tolerance or spec.proof != "auto":
        return
    found = f"A better cam may exist: the gap is {number(100.0 * gap)} %, above the tolerance of "
    found += f"{number(100.0 * spec.tolerance)} %."
    if any(stage.exit == ENDED for stage in design.report.stages):
        yield Finding(
            "note", "proof", found,
            'Ask for "proof": "thorough", which goes on until the gap is closed or time_budget_s '
            "ends, or allow a larger tolerance.",
        )  # fmt: skip
    elif IN_PROOF.format("jerk") in design.certificate.bound_valid_for:
        yield Finding(
            "note",
            "limits/jerk",
            found,
            "Limit the jerk: then a proof that includes curvature is possible.",
        )


RULE = Rule(
    code="gap_open",
    thresholds="note: the gap above the tolerance, where `proof` auto ended by its budget, or a "
    "limit on the jerk would let the proof go on.",
    reason="The cam keeps every limit; how much smaller one may be is not known yet.",
    source="The method of this program: docs/method.md, the bound.",
    checked="This program's own.",
    silenced_by="`proof` quick or thorough",
    find=_find,
)
