"""List and run the benchmarks."""

import argparse
import importlib
import os
import pkgutil
import platform
from pathlib import Path

import benchmarks

NAMES = sorted(m.name for m in pkgutil.iter_modules(benchmarks.__path__) if m.name != "__main__")

HEAD = """# Speed and accuracy

Written by `make bench` on a machine with {cores} cores, Python {python}; other programs may have
been running. Times are medians of one run with the middle half of the values beside them; compare
the ratios within a table, and each time with the error or gap in its row."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Measure speed.")
    parser.add_argument("name", nargs="*", help=f"which of them; all if none: {', '.join(NAMES)}")
    parser.add_argument("--list", action="store_true", help="say which there are")
    parser.add_argument(
        "--write", type=Path, metavar="FILE", help="write what is printed there too"
    )
    asked = parser.parse_args()
    unknown = [name for name in asked.name if name not in NAMES]
    if unknown:
        parser.error(f"there is no {unknown[0]!r}; there are {', '.join(NAMES)}")
    printed = [HEAD.format(cores=os.cpu_count(), python=platform.python_version())]
    for name in asked.name or NAMES:
        module = importlib.import_module(f"benchmarks.{name}")
        if asked.list:
            print(f"{name}: {(module.__doc__ or '').strip().splitlines()[0]}")
            continue
        printed.append(module.run())
        print(printed[-1], end="\n\n", flush=True)
    if asked.write:
        asked.write.parent.mkdir(parents=True, exist_ok=True)
        asked.write.write_text("\n\n".join(printed) + "\n")


if __name__ == "__main__":
    main()
