"""The certificate of a design measured again, line by line."""

from __future__ import annotations

from collections import defaultdict

from flint import arb

from synthesis.catalogue.limits.base import Claim, all_claims
from synthesis.certify.second import Confirmation, Remeasured, Verdict
from synthesis.certify.second.claims import measure_claim, measure_residual_vibration
from synthesis.certify.second.exact_design import ExactDesign
from synthesis.certify.second.exact_motion import BITS, ExactMotion, ball_precision, degree
from synthesis.certify.second.invariants import measure_invariant
from synthesis.certify.second.self_intersection import measure_self_intersection
from synthesis.design.design import Design, Extreme
from synthesis.errors import InputError

Claims = dict[tuple[str, str], list[Claim]]  # by limit and field, in the certificate's order


def recertify(design: Design) -> Confirmation:
    """Measure every line of a design's certificate again."""
    if not design.motion:
        raise InputError(
            "/motion", [], "This design has no cam: there is nothing to measure.",
            "Confirm a design whose status is optimal or feasible.",
        )  # fmt: skip
    spec = design.completed_spec
    claims = defaultdict[tuple[str, str], list[Claim]](list)
    for claim in all_claims(
        spec.all_limits(), design.curve.segments, spec.machine(), tuple(design.size)
    ):
        claims[claim.limit, claim.field].append(claim)
    with ball_precision():
        link = spec.follower.link(tuple(arb(z) for z in design.size), degree())
        exact = ExactDesign(design, link, ExactMotion(design))
        lines = [_measure(exact, extreme, claims) for extreme in design.extremes]
    verdicts = [line.agrees for line in lines]
    verdict: Verdict = "incomplete" if None in verdicts else "confirmed"
    if False in verdicts:
        verdict = "contradicted"
    return Confirmation(id=design.id, name=design.name, verdict=verdict, bits=BITS, lines=lines)


def _measure(design: ExactDesign, extreme: Extreme, claims: Claims) -> Remeasured:
    """The second measurement of one line; claims are used up in the certificate's order."""
    if extreme.limit.startswith("self_crossing"):
        return measure_self_intersection(design, extreme)
    remaining = claims.get((extreme.limit, extreme.field))
    if not remaining:
        return measure_invariant(design, extreme)
    claim = remaining.pop(0)
    if claim.vibration:
        return measure_residual_vibration(design, claim, extreme)
    return measure_claim(design, claim, extreme)
