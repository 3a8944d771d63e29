"""Hypothesis: the same examples on every run; HYPOTHESIS_PROFILE=thorough looks further.

A failing run of the first kind says so at once: looking for a simpler example takes minutes when
each is a whole cam, and is left to the thorough one.
"""

import os

from hypothesis import HealthCheck, Phase, settings

settings.register_profile(
    "ci",
    derandomize=True,
    deadline=None,
    max_examples=20,
    phases=(Phase.explicit, Phase.generate),
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "thorough",
    settings.get_profile("ci"),
    derandomize=False,
    database=None,
    phases=tuple(Phase),
    max_examples=2000,
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))
