"""Lines of the certificate about what has no finite enclosure."""

import math

from synthesis.catalogue.limits.base import Claim
from synthesis.certify import certificate
from synthesis.numerics.enclosure import Enclosure, Extremum


def test_an_extreme_whose_enclosure_is_endless_is_not_proven():
    claim = Claim("jerk", "jerk", (0,), -3.0, 7.0, "mm/s³", lambda v: v, "jerk/max_mm_per_s3")
    for side in (1, -1):
        for ends in ((1.0, 1.0, math.inf), (1.0, -math.inf, 1.0), (math.nan, math.nan, math.nan)):
            extreme = certificate._line(claim, Extremum(Enclosure(*ends, 2.0), side, 7))
            assert (extreme.value, extreme.margin, extreme.holds) == (None, None, False)
            assert "no enclosure" in extreme.evidence
    for ends, bound in (((-3.0, 7.0), 7.0), ((None, 7.0), 7.0), ((-3.0, None), -3.0)):
        claim = Claim("jerk", "jerk", (0,), *ends, "mm/s³", lambda v: v, "jerk/max_mm_per_s3")
        assert certificate._unproven(claim, 0.0, "").bound == bound
