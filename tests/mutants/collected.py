"""A process that has imported the product and collected tests, and is forked for every fault.

To import and collect anew takes longer than most tests that see a fault. A fault changes the body
of a function, and nothing else: so the functions of the module that was imported get the code of
the planted source. What was computed at import is without the fault. A fault that lives here, and
nobody has said why, is therefore planted again in a process that imports everything (``runs.ask``).
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import traceback
from collections import defaultdict
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from types import CodeType, FunctionType

import pytest

from tests.mutants import runs


class Collected:
    """Tests of a copied tree, collected: files or folders of them."""

    def __init__(self, tree: Path, tests: list[str]) -> None:
        self._passes = dict[str, bool]()
        self._requests, requests = multiprocessing.Pipe()
        log = runs.CACHE.absolute() / "collected.log"
        if os.fork() == 0:  # it ends when this process does
            try:
                self._requests.close()
                runs.write_to(log)
                runs.enter(tree)
                runs.run_pytest(tests, _Forks(requests, log.with_name("run.log")))
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(0)
        requests.close()
        self._requests.recv()  # all is imported: from now on files may have faults

    def ask(self, file: Path, before: str, after: str, asked: runs.Asked) -> str:
        """Run tests until one fails, with the functions of a file as another source has them.

        Returns:
            as ``runs.ask``; "" also where the functions cannot be exchanged.
        """
        self._requests.send((str(file), before, after, asked.tests, asked.cpu))
        return str(self._requests.recv())

    def passes(self, test: str) -> bool:
        """Whether a test passes without a fault; each is run once."""
        if test not in self._passes:
            alone = runs.Asked([test], runs.SLOW, "")
            self._passes[test] = not self.ask(Path(), "", "", alone)
        return self._passes[test]


class _Forks:
    """A plugin of pytest that forks at every request, in place of running all tests."""

    def __init__(self, requests: Connection, log: Path) -> None:
        self._requests, self._log, self._first = requests, log, runs.FirstFailure()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        session.config.pluginmanager.register(self._first)
        items = {item.nodeid: item for item in session.items}
        gc.unfreeze()  # what is frozen is not listed
        functions = defaultdict[str, list[FunctionType]](list)
        for each in gc.get_objects():
            if isinstance(each, FunctionType):
                functions[each.__code__.co_filename].append(each)
        gc.freeze()
        self._requests.send(len(items))
        while True:
            try:
                file, before, after, tests, cpu = self._requests.recv()
            except EOFError:
                return True
            chosen = [items[test] for test in tests]
            work = partial(self._work, functions[file], before, after, chosen)
            self._requests.send(runs.verdict(*runs.in_fork(work, cpu, self._log)[:2]))

    def _work(
        self, functions: list[FunctionType], before: str, after: str, tests: list[pytest.Item]
    ) -> tuple[int, str]:
        """In a fork: the exit status of pytest, and the test that failed."""
        if before != after and not _exchange(functions, _codes(before), _codes(after)):
            return 0, ""
        for test, following in zip(tests, [*tests[1:], None], strict=True):
            test.ihook.pytest_runtest_protocol(item=test, nextitem=following)
            if self._first.test:
                return 1, self._first.test
        return 0, ""


Codes = dict[str, list[CodeType]]


def _codes(source: str) -> Codes:
    """The code of all functions of a source by their qualified names, in the order they stand."""
    found = defaultdict[str, list[CodeType]](list)
    pending = [compile(source, "planted", "exec", dont_inherit=True)]
    for code in pending:  # grows
        found[code.co_qualname].append(code)
        pending += [each for each in code.co_consts if isinstance(each, CodeType)]
    return found


def _exchange(functions: list[FunctionType], before: Codes, after: Codes) -> bool:
    """Give functions that exist the code that another source has for them; whether that works."""
    for function in functions:
        code, name = function.__code__, function.__code__.co_qualname
        if code not in before[name] or len(before[name]) != len(after[name]):
            return False
        try:
            function.__code__ = after[name][before[name].index(code)]
        except ValueError:  # it closes over other variables
            return False
    return True
