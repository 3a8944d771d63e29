"""List and run the benchmarks."""

import argparse
import importlib
from pathlib import Path
from time import perf_counter

from benchmarks import page
from benchmarks.effort import FULL, TRIAL, Effort
from benchmarks.section import Section

# In the order of the page.
NAMES = (
    "main_job",
    "solver_share",
    "tolerance",
    "knots",
    "solvers",
    "convex_stage",
    "curvature",
    "proof",
    "pressed",
    "train",
    "neighbours",
    "camshape",
    "camshape_ipopt",
    "profile_points",
    "density",
    "spatial",
    "exports",
    "scaling",
    "http",
    "sweeps",
    "sweep_size",
    "startup",
)
ROOT = Path(__file__).resolve().parents[1]
FOLDER, README = ROOT / "docs" / "benchmarks", ROOT / "docs" / "overview.md"


def section(name: str, effort: Effort) -> Section:
    """Run one benchmark."""
    found: Section = importlib.import_module(f"benchmarks.{name}").run(effort)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description="Measure speed and error."
    )
    parser.add_argument("name", nargs="*", help=f"which of them; all if none: {', '.join(NAMES)}")
    parser.add_argument("--list", action="store_true", help="say which there are")
    parser.add_argument("--trial", action="store_true", help="few sizes and repeats: does it work?")
    parser.add_argument(
        "--write", action="store_true", help="write docs/benchmarks and docs/overview.md"
    )
    question = parser.parse_args()
    unknown = [name for name in question.name if name not in NAMES]
    if unknown:
        parser.error(f"there is no {unknown[0]!r}; there are {', '.join(NAMES)}")
    if question.write and (question.name or question.trial):
        parser.error("the page is written of all benchmarks, run in full")
    if question.list:
        for name in NAMES:
            reported = importlib.import_module(f"benchmarks.{name}").__doc__ or ""
            print(f"{name}: {reported.strip().splitlines()[0]}")
        return
    sections, began = [], perf_counter()
    for name in question.name or NAMES:
        sections.append(section(name, TRIAL if question.trial else FULL))
        print(sections[-1].markdown(), end="\n\n", flush=True)
    print(f"{perf_counter() - began:.0f} s in all")
    if question.write:
        page.write(sections, FOLDER, README)


if __name__ == "__main__":
    main()
