"""Random specs with a limit on residual vibration on top, judged by the verifier."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.hard.random_specs import between, pick, random_spec, spread
from tests.hard.run import outcome

NUMBERS = {
    13: "optimal", 68: "optimal", 134: "optimal", 189: "optimal", 200: "optimal", 255: "optimal",
    288: "optimal", 398: "optimal",
}  # fmt: skip
OFTEN_BROKEN = ("velocity", "acceleration")


def ringing(number: int) -> dict[str, Any]:
    """A random spec with fewer limits on the motion, and one on what it leaves ringing."""
    body, r = random_spec(number), np.random.default_rng(number)
    unit = "deg" if any("lift_deg" in each for each in body["program"]) else "mm"
    lifts = [each.get(f"lift_{unit}") for each in body["program"]]
    lift = max((each for each in lifts if isinstance(each, float)), default=1.0)
    kept = [limit for limit in body.get("limits", []) if limit["kind"] not in OFTEN_BROKEN]
    limit = {
        "kind": "residual_vibration",
        "natural_frequency_hz": body.get("speed_rpm", 60.0) / 60.0 * spread(r, 2.0, 40.0),
        "damping_ratio": pick(r, [0.0, 0.05, between(r, 0.1, 0.6)]),
        f"max_{unit}": pick(r, [0.0, lift * spread(r, 1e-4, 1.0), lift * spread(r, 1e-2, 2.0)]),
    }
    return {**body, "limits": [*kept, limit]}


@pytest.mark.parametrize(("number", "status"), NUMBERS.items())
def test_every_claim_about_ringing_is_confirmed(number: int, status: str) -> None:
    found = outcome(number, ringing(number))
    assert not found.complaints
    assert found.status == status
