"""A core that does what the name of the spec says: for tests of everything around the core."""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
import time
from collections.abc import Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any

from service.settings import Settings
from service.wire.observe import Metrics
from service.workers.engine import Engine, running_engine
from service.workers.tasks import Answer, design_answer
from synthesis.design.design import Certificate, Design, Report
from synthesis.design.identity import design_id, engine_version
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.numerics import clock
from synthesis.spec.design_spec import DesignSpec

LOG = "FAKE_CORE_LOG"


def engine(settings: Settings, metrics: Metrics) -> AbstractAsyncContextManager[Engine]:
    """An engine whose workers have this core."""
    return running_engine(settings, metrics, task, prepare)


def prepare() -> None:
    """Nothing to warm up."""


def task(spec: bytes, budget_s: float, also: Sequence[Any] = (), near: Any = None) -> Answer:
    """Leaves its id to the next, which tells with that where it has begun."""

    def begun(question: DesignSpec, deadline: float, neighbours: list[Any]) -> Design:
        found = synthesise(question, deadline=deadline)
        found = found if near is None else found.with_warm_start(near)
        neighbours.append(found.id)
        return found

    return design_answer(begun, spec, budget_s, also, near)


def synthesise(spec: DesignSpec, *, deadline: float | None = None) -> Design:
    assert deadline is not None
    _log(spec.name)
    word, _, number = spec.name.partition(" ")
    seconds = float(number) if word in ("sleep", "look", "die") and number.strip() else 0.0
    if word == "sleep":
        time.sleep(seconds)
    elif word == "look":
        until = clock.now() + seconds
        while clock.now() < until:
            time.sleep(0.01)
    elif word == "wait":
        _wait_at(Path(number.strip()))
    elif word == "wait-and-die":
        _wait_at(Path(number.strip()))
        os.kill(os.getpid(), signal.SIGKILL)
    elif word == "die":
        time.sleep(seconds)
        os.kill(os.getpid(), signal.SIGKILL)
    elif word == "best":
        raise TimeBudgetExceeded(deadline - time.monotonic(), finished(spec))
    elif word == "empty":
        raise TimeBudgetExceeded(1.5)
    elif word == "solver":
        raise SolverFailed("clarabel", "NumericalError", "Scale the problem.")
    elif word == "bug":
        raise RuntimeError("the secret text of an exception")
    return finished(spec)


class Gate:
    """Where designs named ``wait <folder>`` wait until a test lets them through."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._places = folder, itertools.count()
        folder.mkdir(exist_ok=True)

    def names(self, count: int, word: str = "wait") -> list[str]:
        """Names of that many designs that wait here; the core takes no notice of the spaces."""
        return [f"{word} {self._folder}{' ' * i}" for i in range(count)]

    def let(self, count: int) -> None:
        """Let so many more of them through."""
        for place in itertools.islice(self._places, count):
            (self._folder / f"place {place}").touch()

    def open(self) -> None:
        """Let all of them through."""
        (self._folder / "open").touch()


def _wait_at(gate: Path) -> None:
    """Until there is a place for one more; who waits can be stopped."""
    while not (gate / "open").exists():
        for place in gate.glob("place *"):
            with contextlib.suppress(FileNotFoundError):  # another worker was quicker
                place.unlink()
                return
        clock.now()
        time.sleep(0.01)


def _log(name: str) -> None:
    """A line for every design that is begun, where somebody wants to know."""
    if LOG in os.environ:
        with Path(os.environ[LOG]).open("a", encoding="utf-8") as log:
            log.write(f"{name}\n")


def finished(spec: DesignSpec) -> Design:
    """A cam of 50 mm with an offset of 20 mm, or as the name says: ``sized 37.5 4``."""
    fields: dict[str, Any] = {"stages": [], "seconds": 0.0}
    words = spec.name.split() if spec.name.startswith("sized ") else ["", "50.0", "20.0"]
    radius, offset = float(words[1]), float(words[2])
    return Design(
        id=design_id(spec),
        name=spec.name,
        engine_version=engine_version(),
        status="optimal",
        rotation=spec.rotation,
        speed_rpm=spec.speed_rpm,
        follower=spec.follower.kind,
        dimensions={"base_radius_mm": radius, "prime_radius_mm": 60.0, "offset_mm": offset},
        size=[20.0, 56.5],
        objectives={"base_radius_mm": radius},
        motion=[],
        extremes=[],
        certificate=Certificate(
            certified=True, objective="base_radius", value=50.0, lower_bound=49.9,
            bound_valid_for="a fake", gap=0.002,
        ),
        report=Report(**fields),
        spec=spec,
    )  # fmt: skip
