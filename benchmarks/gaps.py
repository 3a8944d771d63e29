"""A work-precision picture of proofs: gap against time for random scenes of every family.

    python -m benchmarks.gaps [--minutes 10] [--scenes 10] [--family TEXT …] [--jobs 1]
                              [--kept FILE] [--write]

Scenes are those of ``tests.hard.families``. Every clock counts processor time, so that a busy
machine proves as much as an idle one. The first scene of every family comes first, then the
second of each: whenever the run ends, all families have had their turn. With ``--kept FILE`` every
scene is kept, a line each: one that is in it is not asked again, and the page is of all it holds.
"""

from __future__ import annotations

import argparse
import io
import json
import shlex
import sys
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
from math import inf
from pathlib import Path

import numpy as np

from benchmarks import page
from benchmarks.section import Section, Table
from synthesis import Design, DesignSpec, synthesise
from synthesis.design.design import Proof
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.numerics import clock
from synthesis.optimise.driver import UNDIVIDED
from synthesis.optimise.strategy.unmodelled_limits import OPENING
from tests.hard.families import DEFAULT_OBJECTIVES, FAMILIES, random_scene

EVERY = (*FAMILIES, *DEFAULT_OBJECTIVES)
FOLDER = Path(__file__).resolve().parents[1] / "docs" / "benchmarks" / "gaps"
BUDGET_S = 10.0  # of a thorough proof
CLOSED = 0.005  # relative gap: the tolerance of all scenes
LEAST = 1e-4  # relative gap at which the picture ends
LEVELS: Mapping[str, dict[str, object]] = {
    "quick": {"proof": "quick"},
    "auto": {"proof": "auto"},
    "thorough": {"proof": "thorough", "time_budget_s": BUDGET_S},
}
REMEDIES = {
    "time": "more time",
    "node limit": "more nodes",
    UNDIVIDED: "another relaxation or branching",
}
"""What would close a gap, by why the search ended; of the last no more time would."""
GOALS = {"auto": 0.85, "thorough": 0.97}  # shares of scenes that should be closed
NUMBERS = "at the chosen numbers alone"
COLUMNS = 5  # of panels in the picture
LOOKS = {"quick": "#0b57a4", "auto": "#b34700", "thorough": "#00695c"}
TEXT = """*Gap* is the largest of a scene's objectives, proven; 0 where no cam reaches the infimum;
*closed* means that it is within the tolerance of all scenes, {closed}. `quick` and `auto` have
no time budget, `thorough` has {budget:g} s. Seconds are of processor time, one core, from the
spec to the certified design. Where a level closes the gap the later ones would do the same
work, and where there is no cam there is no gap: they are not run, and the figures are repeated.
Families marked * leave numbers free (angles, lifts, an arm's length), and their bounds hold at
the numbers chosen alone.

Written by `make gaps`, here `python -m benchmarks.gaps {arguments}`: {scenes} scenes of {families}
families, {seconds:.0f} s, on {machines}."""


@dataclass(frozen=True)
class Outcome:
    """What one scene came to at one level.

    Attributes:
        seconds: of processor time. gap: relative, the largest of all objectives; inf where one has
            no bound, None without a cam. status: of the design, or why there is none.
        over: what its bound covers. end: why its last search ended. machine: where it was measured.
    """

    family: str
    number: int
    level: str
    seconds: float
    gap: float | None
    status: str
    over: str = ""
    end: str = ""
    machine: str = field(default_factory=page.machine)

    @property
    def closed(self) -> bool:
        """Whether the gap is within the tolerance."""
        return self.gap is not None and self.gap <= CLOSED


def outcome(family: str, number: int, level: str) -> Outcome:
    """Design the cam of a scene, with a proof of a level."""
    spec = DesignSpec.model_validate({**random_scene(family, number), **LEVELS[level]})
    began, status = time.process_time(), ""
    design: Design | None = None
    try:
        design = synthesise(spec)
    except TimeBudgetExceeded as late:
        design, status = late.best, "late"
    except SolverFailed:
        status = "solver failed"
    seconds = time.process_time() - began
    if design is None:
        return Outcome(family, number, level, seconds, None, status)
    proofs = [design.certificate, *design.certificate.other_objectives]
    gap = max(_beyond_allowance(spec, proof) for proof in proofs)
    exits = [stage.exit for stage in design.report.stages if stage.exit]
    return Outcome(
        family, number, level, seconds, gap if design.certificate.certified else None,
        status or design.status, proofs[0].bound_valid_for, exits[-1] if exits else "",
    )  # fmt: skip


def _beyond_allowance(spec: DesignSpec, proof: Proof) -> float:
    """The gap of an objective, to what later ones may make of it at most.

    An infimum that no cam reaches is known for what it is.
    """
    if proof.infimum:
        return 0.0
    if proof.value is None or proof.lower_bound is None or proof.gap is None:
        return inf
    (own,) = (each for each in spec.objectives() if proof.objective.startswith(each.kind))
    if own.allowance is None:
        return proof.gap
    return max(1.0 - proof.lower_bound * (1.0 + own.allowance) / proof.value, 0.0)


def outcomes(family: str, number: int) -> list[Outcome]:
    """A scene at every level; what the quick proof or auto closes is not repeated."""
    found = list[Outcome]()
    for level in LEVELS:
        last = found[-1] if found else None
        known = last is not None and (last.closed or last.gap is None)
        found.append(replace(last, level=level) if known else outcome(family, number, level))
    return found


def measured(
    families: Sequence[str], scenes: int, seconds: float, jobs: int, kept: Path | None
) -> list[Outcome]:
    """The outcomes of scenes by number, then family.

    Args:
        families: their names. scenes: of every family.
        seconds: of processor time, after which no scene is begun.
        jobs: processes. kept: file of outcomes; scenes that it holds are not asked again.
    """
    found = _read(kept)
    known = {(one.family, one.number) for one in found}
    every = [(family, number) for number in range(scenes) for family in families]
    spent = 0.0
    with ProcessPoolExecutor(jobs, initializer=_count_processor_time) as pool:
        tasks = [pool.submit(outcomes, *scene) for scene in every if scene not in known]
        for task in as_completed(tasks):
            levels = task.result()
            found += levels
            spent += _seconds(levels)
            last = levels[-1]
            text = ", ".join(f"{o.level} {_percent(o.gap)} {o.seconds:.2f} s" for o in levels)
            print(f"{last.family} #{last.number}: {text}, {last.status}", flush=True)
            if kept is not None:
                with kept.open("a") as file:
                    file.writelines(json.dumps(asdict(one)) + "\n" for one in levels)
            if spent >= seconds:
                pool.shutdown(cancel_futures=True)
                break
    return found


def _seconds(found: Iterable[Outcome]) -> float:
    """Of processor time in all; a figure that is repeated at a later level counts once."""
    return sum(seconds for *_, seconds in {(o.family, o.number, o.seconds) for o in found})


def _count_processor_time() -> None:
    clock.now = time.process_time


def _read(kept: Path | None) -> list[Outcome]:
    """The outcomes of earlier runs."""
    lines = kept.read_text().splitlines() if kept is not None and kept.exists() else []
    return [Outcome(**json.loads(line)) for line in lines]


def section(found: Sequence[Outcome], arguments: str, seconds: float) -> Section:
    """The page: shares of closed scenes, families that fall short, all families, the picture."""
    names = [name for name in EVERY if any(one.family == name for one in found)]
    found = sorted(found, key=lambda one: one.number)
    text = TEXT.format(
        closed=_percent(CLOSED), budget=BUDGET_S, arguments=arguments,
        scenes=len(found) // len(LEVELS), families=len(names), seconds=seconds,
        machines=" and on ".join(dict.fromkeys(one.machine for one in found)),
    )  # fmt: skip
    grouped = {
        name: {
            level: [one for one in found if (one.family, one.level) == (name, level)]
            for level in LEVELS
        }
        for name in names
    }
    return Section(
        "Proofs: gap against time",
        text,
        [_shares(found), _short(grouped), _families(grouped), Picture(grouped)],
    )


Grouped = Mapping[str, Mapping[str, list[Outcome]]]


def _shares(found: Iterable[Outcome]) -> Table:
    """How many scenes with a cam are closed, level by level."""
    rows = []
    for level in LEVELS:
        gaps = _gaps(one for one in found if one.level == level)
        seconds = [one.seconds for one in found if one.level == level]
        goal = _share(GOALS[level]) if level in GOALS else "–"
        rows.append((
            level, _share(np.mean(gaps <= CLOSED)), goal, _share(np.mean(gaps <= 0.05)),
            _percent(np.median(gaps)), _percent(_tenth_worst(gaps)),
            f"{np.median(seconds):.2f} s", f"{_tenth_worst(seconds):.2f} s",
        ))  # fmt: skip
    without = [one for one in found if one.level == "thorough" and one.gap is None]
    words = ", ".join(f"{one.family} #{one.number} ({one.status})" for one in without)
    return Table(
        ("proof", ">closed", ">goal", ">within 5 %", ">median gap", ">9 of 10 below",
         ">median time", ">9 of 10 below"),
        rows,
        "All scenes with a cam." + (f" Without one, and not counted: {words}." if words else ""),
    )  # fmt: skip


def _short(grouped: Grouped) -> Table:
    """Families with open gaps after a thorough proof: what ended it, what its bound leaves out."""
    rows = []
    for name, levels in grouped.items():
        opened = [one for one in levels["thorough"] if one.gap is not None and not one.closed]
        if opened:
            end = Counter("time" if one.status == "late" else one.end for one in opened)
            ((reason, _),) = end.most_common(1)
            left_out = max((one.over for one in opened), key=len).partition(OPENING)[2]
            rows.append((
                _marked(name, levels), f"{len(opened)} of {len(levels['thorough'])}",
                _percent(max(one.gap or 0.0 for one in opened)), reason, left_out or "–",
                REMEDIES.get(reason, "–"),
            ))  # fmt: skip
    return Table(
        ("family", ">open", ">largest gap", "ended by", "active, not wholly in the bound",
         "what would close it"),
        rows,
        "### Families that fall short of 0.5 % with a thorough proof\n\n"
        "*Ended by* is the `exit` of the report, of several the most frequent. *The lowest node is "
        "not divided*: no branching is known for what leaves the gap, and more time buys nothing.",
    )  # fmt: skip


def _families(grouped: Grouped) -> Table:
    """Time and gap of every family at every level: the median, and what nine of ten are below."""
    rows = []
    for name, levels in grouped.items():
        cells = []
        for found in levels.values():
            gaps = _gaps(found)
            spread = (np.median, _tenth_worst)
            cells += [
                f"{np.median([one.seconds for one in found]):.2f} s",
                " / ".join(_percent(each(gaps)) for each in spread) if len(gaps) else "–",
            ]
        rows.append((_marked(name, levels), str(len(levels["quick"])), *cells))
    head = [name for level in LEVELS for name in (f">{level}", ">gap")]
    return Table(
        ("family", ">scenes", *head),
        rows,
        "### All families\n\nTimes are medians; of gaps the median stands before the value that "
        "nine of ten scenes are below.",
    )


def _marked(name: str, levels: Mapping[str, list[Outcome]]) -> str:
    return f"{name} *" if any(NUMBERS in one.over for one in levels["quick"]) else name


def _gaps(found: Iterable[Outcome]) -> np.ndarray:
    """Of scenes with a cam; one without a bound has a gap of 1."""
    return np.array([min(one.gap, 1.0) for one in found if one.gap is not None])


def _tenth_worst(values: Sequence[float] | np.ndarray) -> float:
    """The value that nine of ten do not exceed, one of the values themselves."""
    return float(np.quantile(values, 0.9, method="inverted_cdf"))


def _share(value: float) -> str:
    return f"{100.0 * value:.0f} %"


def _percent(gap: float | None) -> str:
    return "no cam" if gap is None else f"{100.0 * min(gap, 1.0):.3g} %"


@dataclass(frozen=True)
class Picture:
    """A panel for each family: every scene a line from quick over auto to thorough."""

    grouped: Grouped

    def markdown(self) -> str:
        return (
            "### The picture\n\nEach line is a scene: the dots are its time and gap with a quick "
            "proof, with auto and with a thorough one. Below the broken line a gap is closed.\n\n"
            "![Gap against time, a panel for each family](gaps.svg)"
        )

    def files(self) -> Mapping[str, bytes]:
        return {"gaps.svg": self.svg()}

    def svg(self) -> bytes:
        """The drawing; the same outcomes give the same bytes."""
        import matplotlib as mpl
        from matplotlib.figure import Figure

        rows = -(-len(self.grouped) // COLUMNS)
        with mpl.rc_context({"svg.hashsalt": "gaps", "svg.fonttype": "none", "font.size": 6}):
            figure = Figure(figsize=(2.1 * COLUMNS, 1.35 * rows), layout="constrained")
            panels = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False)
            panels = list(panels.flat)
            for panel, (name, levels) in zip(panels, self.grouped.items(), strict=False):
                panel.set_title(name, fontsize=6)
                panel.axhline(100.0 * CLOSED, color="#8a939d", linewidth=0.6, linestyle="--")
                for scene in zip(*levels.values(), strict=True):
                    points = [
                        (one.seconds, 100.0 * max(min(one.gap, 1.0), LEAST))
                        for one in scene
                        if one.gap is not None
                    ]
                    if points:
                        panel.plot(*zip(*points, strict=True), color="#c3c9d0", linewidth=0.6)
                    for one, point in zip(scene, points, strict=False):
                        panel.plot(*point, ".", color=LOOKS[one.level], markersize=3.5)
                panel.set(xscale="log", yscale="log", ylim=(80.0 * LEAST, 130.0))
                panel.minorticks_off()
            for panel in panels[len(self.grouped) :]:
                panel.set_axis_off()
            marks = [
                mpl.lines.Line2D([], [], color=c, marker=".", linestyle="") for c in LOOKS.values()
            ]
            figure.legend(marks, list(LOOKS), loc="outside lower right", ncols=3, frameon=False)
            figure.supxlabel("processor time [s]")
            figure.supylabel("proven gap [%]")
            out = io.BytesIO()
            figure.savefig(out, format="svg", metadata={"Date": None})
        return out.getvalue()


def write(made: Section, folder: Path) -> None:
    """Write the page and its picture into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in made.files().items():
        (folder / name).write_bytes(data)
    text = made.markdown().removeprefix("#")
    (folder / "README.md").write_text(f"{text}\n", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gaps", description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0, help="of processor time, at most")
    parser.add_argument("--scenes", type=int, default=10, help="of every family, at most")
    parser.add_argument(
        "--family", nargs="*", default=[""], help="texts; families with one of them"
    )
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--kept", type=Path, help="file of scenes, not asked again")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks/gaps")
    given = parser.parse_args()
    families = [name for name in EVERY if any(text in name for text in given.family)]
    found = measured(families, given.scenes, 60.0 * given.minutes, given.jobs, given.kept)
    # the page names no folder of the machine
    arguments = [Path(each).name if each == str(given.kept) else each for each in sys.argv[1:]]
    made = section(found, shlex.join(arguments), _seconds(found))
    print(made.markdown())
    if given.write:
        write(made, FOLDER)


if __name__ == "__main__":
    main()
