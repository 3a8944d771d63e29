"""What all tests share: how Hypothesis looks for examples, and how conflicts are explained.

Hypothesis has the same examples on every run; HYPOTHESIS_PROFILE=thorough looks further. A failing
run of the first kind says so at once: looking for a simpler example takes minutes when each is a
whole cam, and is left to the thorough one.
"""

import gc
import os
from collections.abc import Callable, Iterator

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants

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
    max_examples=12,
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

# Hypothesis draws numbers that stand in the loaded modules of this project, too: a test would have
# other examples beside other tests than alone. No setting turns that off.
providers._get_local_constants = Constants


# Why a spec has no cam: to find that out takes many searches.

CONFLICT, BOUNDARY = "synthesis.pipeline.conflict", "synthesis.pipeline.boundary"


@pytest.fixture(scope="module")
def coarse_conflicts() -> Iterator[None]:
    """Values that suffice end within four parts in a hundred of the way: fewer trials.

    How near to each other the ends are brought is tested by ``test_boundary``, without this.

    Changes of the program, which have tests of their own, are not sought.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("synthesis.pipeline.conflict.ACCURACIES", (4e-2,))
        patch.setattr(f"{BOUNDARY}.FINE", 5e-3)
        patch.setattr(f"{BOUNDARY}.FINEST", dict.fromkeys(("quick", "auto", "thorough"), 5e-3))
        patch.setattr(f"{CONFLICT}.program_numbers", lambda *_: ())
        yield


@pytest.fixture
def explain_only(coarse_conflicts: None, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Sets the field that conflicts are explained by: each number takes searches of its own."""
    from synthesis.pipeline.relaxable import relaxable_numbers

    def only(field: str) -> None:
        monkeypatch.setattr(
            f"{CONFLICT}.relaxable_numbers",
            lambda spec: [n for n in relaxable_numbers(spec) if field in n.paths],
        )

    return only


@pytest.fixture
def unexplained(explain_only: Callable[[str], None]) -> None:
    """Of a spec without a cam that is told alone, with its proof, and none of its numbers tried."""
    explain_only("")


@pytest.fixture
def unmended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Analyses do not search for what mends a cam: that takes a design for each size."""
    monkeypatch.setattr("synthesis.studies.analyse.find_remedy", lambda *_: None)
