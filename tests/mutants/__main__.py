"""Plant faults in the product and see whether a test fails; ``make mutants``.

Each fault is planted alone in a copy of the working tree. Tests that reach its lines run, the
fastest first, until one fails. Which lines a test reaches is recorded once, and again when its file
changes. What was found is kept in ``.mutants/``: an interrupted run continues, and only faults
whose file or tests have changed are planted anew.

Exit status 1: a survivor has no reason in ``reasons.json``, or less than 95 % were seen.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import islice, zip_longest
from pathlib import Path

from tests.mutants.collected import Collected
from tests.mutants.operators import Fault, Module, faults
from tests.mutants.runs import CACHE, Asked, ask, copy_tree, import_libraries, plant, record

SHARE = 0.95  # of the faults that tests see at least
REASONS = Path(__file__).with_name("reasons.json")
# Functions that decide how soon an answer comes, where knots lie, which of all multipliers, any of
# which are valid, make a bound: nothing of what is claimed.
SPEED = re.compile(
    r"\b(initial_boxes|sign_changes|losses|PointBounds\.width|mean_width|is_sampled"
    r"|RowFunctional\.distribute|window_multipliers|directions_around|_divided_by_turning"
    r"|tighten_sizes|binds_on_fixed_motion)$"
)
REPORT = Path("docs/mutants.md")


@dataclass(frozen=True)
class Room:
    """A part of the product: its sources, how many faults, and the tests that may see them."""

    name: str
    count: int
    sources: tuple[str, ...]
    tests: tuple[str, ...]
    store: bool = False


# Tests of whole designs (pipeline, studies) take seconds each and see little that these do not.
NEAR = ("catalogue", "machines/dynamics")
HUBS = ("pipeline/test_hub.py",)
ANALYSES = tuple(f"studies/test_{each}.py" for each in ("analyse", "analyse_arm", "self_crossing"))
SWEEPS = tuple(  # without those that kill processes and wait
    f"service/sweeps/test_{each}.py"
    for each in ("leases", "runner", "sweep_store", "sweeps", "warm_sweeps")
)
RESOURCES = tuple(f"service/resources/test_{each}.py" for each in ("designs", "earlier_engines"))
KEYS = ("service/wire/test_access.py", "service/commands/test_keys.py")
# What bounds over all laws rest on: rows, their functionals, least integrals, ranges. The rest of
# the optimiser proposes cams and multipliers, of which any are valid, and meshes.
BOUNDS = (
    "conic/control", "conic/law_bounds", "conic/linear_rows", "conic/subprogram",
    "conic/tangent_cuts", "dual_bound/batch", "dual_bound/bound", "dual_bound/lagrangian",
    "dual_bound/multiplier_density", "dual_bound/row_functionals", "dual_bound/switching",
    "propagation/*", "relaxation/*",
)  # fmt: skip
ROOMS = (
    Room("certify", 150, ("synthesis/certify/*.py",), ("certify", *NEAR, *ANALYSES, *HUBS)),
    Room("second", 100, ("synthesis/certify/second/*.py",), ("certify", *NEAR, *HUBS)),
    Room(
        "optimise", 120, tuple(f"synthesis/optimise/{file}.py" for file in BOUNDS),
        ("optimise", *NEAR),
    ),
    Room(
        "store", 80, ("service/storage/*.py", "service/sweeps/[cst]*.py"),
        ("service/storage", *SWEEPS, *RESOURCES, *KEYS), store=True,
    ),
)  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(prog="make mutants", description=__doc__)
    parser.add_argument("--room", choices=[room.name for room in ROOMS], action="append")
    parser.add_argument("--count", type=int, help="of faults in each room")
    parser.add_argument("--seed", type=int, default=1, help="which faults are planted")
    parser.add_argument("--seconds", type=float, default=12.0, help="of tests for a fault at most")
    parser.add_argument("--match", default="", help="only faults whose name has this")
    parser.add_argument("--write", action="store_true", help=f"write {REPORT}")
    options = parser.parse_args()
    import_libraries()
    tree = CACHE.absolute() / "tree"
    copy_tree(tree)
    found = list[tuple[Room, Fault, str]]()
    for room in ROOMS:
        if room.name in (options.room or [room.name]):
            planted = chosen(room, tree, options.seed, options.match)
            count = room.count if options.count is None else options.count
            found += _plant_all(room, list(islice(planted, count)), tree, options.seconds)
    text, passed = report(found, reasons())
    print(text)
    if options.write:
        REPORT.write_text(text)
    return 0 if passed else 1


def chosen(room: Room, tree: Path, seed: int, match: str = "") -> Iterator[Fault]:
    """Faults of a room, of each operator in turn; the order stays when other code changes."""
    by_operator = defaultdict[str, list[tuple[str, Fault]]](list)
    sources = dict[str, str]()
    for pattern in room.sources:
        for path in sorted(tree.glob(pattern)):
            file = path.relative_to(tree).as_posix()
            sources[file] = path.read_text()
            for fault in faults(file, sources[file], store=room.store):
                order = hashlib.sha256(f"{seed} {fault.key}".encode()).hexdigest()
                by_operator[fault.operator].append((order, fault))
    queues = [sorted(each, key=lambda pair: pair[0]) for each in by_operator.values()]
    for turn in zip_longest(*queues):
        for _, fault in filter(None, turn):
            of_speed = SPEED.search(fault.scope)
            if not of_speed and match in fault.key and fault.changes(sources[fault.file]):
                yield fault


def _plant_all(
    room: Room, planted: list[Fault], tree: Path, seconds: float
) -> Iterator[tuple[Room, Fault, str]]:
    """Every fault with what sees it, "" where nothing does."""
    reached, path = Reached(room, tree), CACHE / "results.json"
    results: dict[str, str] = json.loads(path.read_text()) if path.exists() else {}
    for number, fault in enumerate(planted, 1):
        source = (tree / fault.file).read_text()
        asked = reached.tests(fault, source, seconds)
        code = hashlib.sha256(fault.plant(source).encode()).hexdigest()
        survived = f"{code} {asked.digest}"
        seen_by = results.get(code, results.get(survived))
        started = time.monotonic()
        if seen_by is None:
            seen_by = _seen_by(room, tree, fault, source, asked)
            results[code if seen_by else survived] = seen_by
            path.write_text(json.dumps(results))
        said = seen_by or f"LIVES ({len(asked.tests)} tests)"
        took = f"{time.monotonic() - started:.0f} s"
        print(
            f"{room.name} {number}/{len(planted)} {fault.place} {fault.key}\n    {said}, {took}",
            flush=True,
        )
        yield room, fault, seen_by


def _seen_by(room: Room, tree: Path, fault: Fault, source: str, asked: Asked) -> str:
    """The test that sees a fault, "" where none does."""
    file, planted = tree / fault.file, fault.plant(source)
    collected = _collected(tree, room.store)
    if not asked.tests:
        return ""
    with plant(file, planted):
        seen_by = collected.ask(file, source, planted, asked)
        if not seen_by and fault.key not in reasons():
            seen_by = ask(tree, asked)
    if seen_by in asked.tests and not collected.passes(seen_by):
        sys.exit(f"{seen_by} fails without a fault")
    return seen_by


@cache
def reasons() -> dict[str, str]:
    """Why faults that live change nothing, by their names."""
    return dict(json.loads(REASONS.read_text()))


@cache
def _collected(tree: Path, store: bool) -> Collected:
    """The tests of all rooms of the core, or of the store."""
    names = dict.fromkeys(name for room in ROOMS if room.store == store for name in room.tests)
    return Collected(tree, [f"tests/{name}" for name in names])


class Reached:
    """Which tests reach which lines of a room, and what they take."""

    def __init__(self, room: Room, tree: Path) -> None:
        self._seconds, self._digests = dict[str, float](), dict[str, str]()
        self._of_line = defaultdict[str, dict[str, None]](dict)  # of lines and whole functions
        for name in room.tests:
            path = tree / "tests" / name
            for file in [path] if path.is_file() else sorted(path.rglob("test_*.py")):
                names, tests = record(tree, file.relative_to(tree))
                digest = hashlib.sha256(file.read_bytes()).hexdigest()
                for test, (seconds, lines) in tests.items():
                    self._seconds[test], self._digests[test] = seconds, digest
                    for line in lines:
                        for name in (names[line], names[line].partition(": ")[0]):
                            self._of_line[name][test] = None

    def tests(self, fault: Fault, source: str, most: float) -> Asked:
        """Tests that reach a fault, those that say most in a second first.

        Cases of one test are alike: the first counts once, the next twice, and so on.
        """
        names = Module(source).line_names
        own, around = (
            [f"{fault.file} {names[line]}" for line in lines]
            for lines in (fault.lines, fault.statement)
        )
        reach = dict[str, bool]()
        for places in (own, around):
            reach = reach or {test: False for name in places for test in self._of_line[name]}
        # Lines may be new since tests were recorded: at last those that reach the function.
        for name in {name.partition(": ")[0] for name in around}:
            reach = dict.fromkeys(self._of_line[name], True) | reach
        cases, costs = Counter[str](), dict[str, float]()
        for test in sorted(reach, key=lambda test: (self._seconds[test], test)):
            cases[test.partition("[")[0]] += 1
            costs[test] = self._seconds[test] * cases[test.partition("[")[0]]
        tests, total = list[str](), 0.0
        for test in sorted(costs, key=lambda test: (reach[test], costs[test], test)):
            if total + self._seconds[test] <= most:
                tests.append(test)
                total += self._seconds[test]
        digest = hashlib.sha256(
            "".join(f"{test} {self._digests[test]}" for test in sorted(tests)).encode()
        )
        return Asked(tests, total, digest.hexdigest())


def report(found: list[tuple[Room, Fault, str]], why: dict[str, str]) -> tuple[str, bool]:
    """A table of rooms and operators, and the survivors with their reasons; whether it passes."""
    planted, seen = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for room, fault, seen_by in found:
        for place in ((room.name, fault.operator), (room.name, "all"), ("all", fault.operator)):
            planted[place] += 1
            seen[place] += bool(seen_by)
    operators = sorted({fault.operator for _, fault, _ in found})
    total, total_seen = len(found), sum(bool(seen_by) for *_, seen_by in found)
    lines = [
        "# Planted faults", "",
        "`make mutants` plants faults in the product, one at a time, and runs tests that reach it.",
        f"Of {total} faults tests see {total_seen} ({100.0 * total_seen / max(total, 1):.1f} %);"
        " each cell: seen of planted.", "",
        f"| room | {' | '.join(operators)} | all |", f"|---|{'---|' * (len(operators) + 1)}",
    ]  # fmt: skip
    for name in (*dict.fromkeys(room.name for room, *_ in found), "all"):
        cells = [f"{seen[name, one]} of {planted[name, one]}" for one in (*operators, "all")]
        if name == "all":
            cells[-1] = f"{total_seen} of {total}"
        lines.append(f"| {name} | {' | '.join(cells)} |")
    survivors = [fault for _, fault, seen_by in found if not seen_by]
    unexplained = [fault for fault in survivors if fault.key not in why]
    lines += ["", "## Survivors", ""]
    for fault in survivors:
        lines.append(f"* `{fault.key}`: {why.get(fault.key, 'no reason is given')}")
    if not survivors:
        lines.append("None.")
    passed = not unexplained and total_seen >= SHARE * total
    return "\n".join([*lines, ""]), passed


if __name__ == "__main__":
    sys.exit(main())
