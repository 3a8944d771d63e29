"""Hypothesis: the same examples on every run; HYPOTHESIS_PROFILE=thorough looks further.

A failing run of the first kind says so at once: looking for a simpler example takes minutes when
each is a whole cam, and is left to the thorough one.
"""

import gc
import os

from hypothesis import HealthCheck, Phase, settings

# What collecting the tests creates (modules, classes, syntax trees, test items) lives to the end of
# the run. The garbage collector walks over all of it again and again, for half of the processor
# time of a collection, and finds nothing: it waits until then, and passes over it afterwards.
gc.disable()


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.enable()


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
