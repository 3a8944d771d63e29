"""Which limits a given cam breaks, by the judge of analyses alone.

An analysis also looks for what would mend the cam, which takes seconds where curvature or an arm's
pressure angle binds; tests of that are in tests/studies.
"""

from __future__ import annotations

from synthesis.pipeline.assembly import certify_cam
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.analyse import given_cam


def broken(spec: DesignSpec) -> list[str]:
    """Their names, as an analysis lists them."""
    return [extreme.limit for extreme in certify_cam(spec, given_cam(spec)) if not extreme.holds]
