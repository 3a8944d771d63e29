"""Tests run in forked processes: which lines each of them reaches, and whether one sees a fault.

Libraries are imported once, by the process that is forked; the product and the tests are imported
after the fork, from a copy of the working tree in which the fault is planted.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
import traceback
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import coverage
import pytest

from tests.mutants.operators import Module

LIBRARIES = (
    "casadi", "clarabel", "distributed", "fastapi", "flint", "highspy", "httpx2",
    "hypothesis", "numpy", "pydantic", "scipy.interpolate", "scipy.optimize",
    "scipy.sparse.linalg", "sqlalchemy.ext.asyncio", "alembic.command", "uvicorn",
)  # fmt: skip
OURS = ("synthesis", "service", "tests", "benchmarks")
PRODUCT = ("synthesis/certify", "synthesis/optimise", "service/storage", "service/sweeps")
CACHE = Path(".mutants")  # what was recorded and found
SLOW = 5.0  # processor time of a test that is not asked [s]
SLOW_FILE = 45.0  # processor time of a file of tests, after which its other tests are not recorded
IMPORTED = "ignore::pytest.PytestAssertRewriteWarning"  # what is imported before the fork
WAITING = 4.0  # a second of waiting costs as much as a quarter of a second's work
CPU_SHARE = 2.0  # of the time that tests take, before a fault counts as an endless loop
LEAST = 10.0  # processor time that every run has [s]
WALL = 6.0  # of its processor time, what a run may take at all: it waits, or others use the cores
Reached = tuple[list[str], dict[str, tuple[float, list[int]]]]


def import_libraries() -> None:
    """What is imported before forks, and never has a fault."""
    for name in LIBRARIES:
        importlib.import_module(name)


def copy_tree(to: Path) -> None:
    """A copy of the working tree; files that have not changed stay as they are."""
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "-z", "--", *OURS, "*.*"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    wanted = {name for name in listed.stdout.split("\0") if name and Path(name).is_file()}
    for old in to.rglob("*"):
        name = str(old.relative_to(to))
        if old.is_file() and "__pycache__" not in name and name not in wanted:
            old.unlink()
    for name in wanted:
        if not (to / name).exists() or (to / name).read_bytes() != Path(name).read_bytes():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(name, to / name)


def in_fork(work: Callable[[], Any], cpu: float, log: Path) -> tuple[int, Any, float]:
    """Run ``work`` in a child of this process.

    Args:
        cpu: processor time after which it is ended [s]; after ``WALL`` times that, anyhow.
        log: where its output goes.

    Returns:
        the exit status (−9: it was ended), what ``work`` returned, and its processor time [s].
    """
    answer = log.with_suffix(".answer").absolute()
    answer.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.setsid()
            write_to(log)
            resource.setrlimit(resource.RLIMIT_CPU, (int(cpu) + 1, int(cpu) + 3))
            answer.write_text(json.dumps(work()))
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            os._exit(code)
    ends, status, used = time.monotonic() + WALL * cpu, 0, None
    while used is None:
        ended, status, usage = os.wait4(child, os.WNOHANG)
        if ended:
            used = usage.ru_utime + usage.ru_stime
        elif time.monotonic() > ends:
            os.kill(child, signal.SIGKILL)
            ends = inf
        else:
            time.sleep(0.01)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # what it has started itself
    code = os.waitstatus_to_exitcode(status)
    said = json.loads(answer.read_text()) if code == 0 else None
    return code, said, used


def write_to(log: Path) -> None:
    output = os.open(log, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(output, stream)


def enter(tree: Path) -> None:
    """Make this process one that was started in ``tree``: its modules come from there."""
    here = str(Path.cwd())
    os.chdir(tree)
    sys.path[:] = [str(Path.cwd()), *(p for p in sys.path if p not in ("", here))]
    os.environ["PYTHONPATH"] = str(Path.cwd())
    for name in [name for name in sys.modules if name.partition(".")[0] in OURS]:
        del sys.modules[name]
    importlib.invalidate_caches()


def run_pytest(arguments: list[str], plugin: object) -> int:
    return int(
        pytest.main(["-q", "-p", "no:cacheprovider", "-W", IMPORTED, *arguments], plugins=[plugin])
    )


# --- which lines tests reach ----------------------------------------------------------------------


class TooSlow(BaseException):
    """A test has used up its time."""


def _end_test(*_: object) -> None:
    raise TooSlow


class Recorder:
    """A plugin of pytest that records the lines and the time of every test that passes.

    What a fixture of a wider scope than one test does counts for all tests that ask for it.
    """

    def __init__(self) -> None:
        sources = [folder for folder in PRODUCT if Path(folder).exists()]
        self._coverage = coverage.Coverage(data_file=None, config_file=False, source=sources)
        self._seconds, self._uses = defaultdict[str, float](float), dict[str, list[str]]()
        self._context, self._ended = "", set[str]()
        self._coverage.start()
        signal.signal(signal.SIGPROF, _end_test)

    @contextlib.contextmanager
    def _in_context(self, context: str) -> Iterator[None]:
        before, cpu, wall = self._context, time.process_time(), time.monotonic()
        self._context = context
        self._coverage.switch_context(context)
        try:
            yield
        finally:
            used = max(time.process_time() - cpu, (time.monotonic() - wall) / WAITING)
            self._seconds[context] += used
            self._context = before
            self._coverage.switch_context(before)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any, request: Any) -> Iterator[None]:
        if fixturedef.scope == "function":
            return (yield)
        with self._in_context(f"fixture {fixturedef.argname} {request.param_index}"):
            return (yield)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self) -> bool | None:
        return True if time.process_time() > SLOW_FILE else None  # True: it has been run

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        chosen = getattr(item, "callspec", None)  # which of a fixture's parameters it has
        self._uses[item.nodeid] = [
            f"fixture {name} {chosen.indices.get(name, 0) if chosen else 0}"
            for name in item.fixturenames  # type: ignore[attr-defined]
        ]
        signal.setitimer(signal.ITIMER_PROF, SLOW)
        with self._in_context(item.nodeid):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        try:
            with self._in_context(item.nodeid):
                return (yield)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.outcome != "passed":
            self._ended.add(report.nodeid)

    def tests(self) -> Reached:
        self._coverage.stop()
        data = self._coverage.get_data()
        names = list[str]()
        lines = defaultdict[str, set[int]](set)
        for file in sorted(data.measured_files()):
            path = str(Path(file).relative_to(Path.cwd()))
            line_names = Module(Path(file).read_text()).line_names
            for line, contexts in data.contexts_by_lineno(file).items():
                for context in contexts:
                    lines[context].add(len(names))
                names.append(f"{path} {line_names[line]}")
        tests = {}
        for test in self._uses.keys() - self._ended:
            contexts = [test, *self._uses[test]]
            contexts = [each for each in contexts if each in self._seconds]
            seconds = sum(self._seconds[each] for each in contexts)
            tests[test] = seconds, sorted(set[int]().union(*(lines[each] for each in contexts)))
        return names, tests


def record(tree: Path, tests: Path) -> Reached:
    """What the tests of a file reach; of a file that has not changed since, from the cache."""
    digest = hashlib.sha256((tree / tests).read_bytes()).hexdigest()[:16]
    kept = CACHE / "reached" / f"{tests.as_posix().replace('/', '-')}-{digest}.json"
    if kept.exists():
        names, found = json.loads(kept.read_text())
        return names, found

    log = CACHE.absolute() / "record.log"

    def work() -> Reached:
        enter(tree)
        recorder = Recorder()
        run_pytest([str(tests)], recorder)
        return recorder.tests()

    code, said, used = in_fork(work, 2.0 * SLOW_FILE, log)
    if said is None and code != -signal.SIGKILL:
        sys.exit(f"{tests} could not be recorded: see {log}")
    names, found = said or ([], {})
    print(
        f"{tests}: {len(found)} tests in {used:.0f} s{'' if code == 0 else ', ended'}", flush=True
    )
    kept.parent.mkdir(parents=True, exist_ok=True)
    for old in kept.parent.glob(f"{kept.name[: -len(digest) - 5]}*"):
        old.unlink()
    kept.write_text(json.dumps((names, found)))
    return names, found


# --- whether tests see a fault --------------------------------------------------------------------


class FirstFailure:
    """A plugin of pytest that notes the first test that fails."""

    def __init__(self) -> None:
        self.test = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.test:
            self.test = report.nodeid


@dataclass(frozen=True)
class Asked:
    """Tests to run, what they take without a fault [s], and a digest of them."""

    tests: list[str]
    seconds: float
    digest: str

    @property
    def cpu(self) -> float:
        """Processor time that they have [s]."""
        return CPU_SHARE * self.seconds + LEAST


@contextlib.contextmanager
def plant(path: Path, source: str) -> Iterator[None]:
    """A file of the copied tree with another source."""
    before, times = path.read_bytes(), path.stat()
    path.write_text(source)
    # Bytecode is kept by time and size: no two faults have the same time.
    second = 10**9 + zlib.crc32(source.encode()) // 8
    os.utime(path, (second, second))
    try:
        yield
    finally:
        path.write_bytes(before)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def ask(tree: Path, asked: Asked) -> str:
    """Run tests until one fails; its name, "" where none does, and what else ended the run."""
    log = CACHE.absolute() / "run.log"

    def work() -> tuple[int, str]:
        enter(tree)
        first = FirstFailure()
        return run_pytest(["-x", *asked.tests], first), first.test

    return verdict(*in_fork(work, asked.cpu, log)[:2])


def verdict(code: int, said: tuple[int, str] | None) -> str:
    """What ended tests: ``code`` of their process, and what it said: pytest's status, the test."""
    if said is None:
        return "endless" if code in (-signal.SIGKILL, -signal.SIGXCPU) else "crash"
    status, test = said
    return "" if status == pytest.ExitCode.OK else test or "collection"
