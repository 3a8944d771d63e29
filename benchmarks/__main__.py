"""List and run the benchmarks."""

import argparse
import importlib
import pkgutil

import benchmarks

NAMES = sorted(m.name for m in pkgutil.iter_modules(benchmarks.__path__) if m.name != "__main__")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Measure speed.")
    parser.add_argument("name", nargs="*", help=f"which of them; all if none: {', '.join(NAMES)}")
    parser.add_argument("--list", action="store_true", help="say which there are")
    asked = parser.parse_args()
    unknown = [name for name in asked.name if name not in NAMES]
    if unknown:
        parser.error(f"there is no {unknown[0]!r}; there are {', '.join(NAMES)}")
    for name in asked.name or NAMES:
        module = importlib.import_module(f"benchmarks.{name}")
        if asked.list:
            print(f"{name}: {(module.__doc__ or '').strip().splitlines()[0]}")
        else:
            print(module.run(), end="\n\n", flush=True)


if __name__ == "__main__":
    main()
