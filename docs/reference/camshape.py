"""Print the table of camshape.md: the largest cams, and what was published.

python docs/reference/camshape.py
"""

from collections.abc import Iterator

from benchmarks.camshape import PUBLISHED, SIZES, bound, shape, value


def rows() -> Iterator[str]:
    for n in SIZES:
        reached = value(shape(n))
        above = "1e-8" if 0.0 <= bound(n).value - reached <= 1e-8 else "more"
        reported = f"{PUBLISHED[n]:.9f}" if n in PUBLISHED else "not found"
        yield f"| {n} | {reached:.9f} | {reported} | {above} |"


def main() -> None:
    print("| n | optimum | published, proven | proven bound above it by less than |")
    print("|--:|--:|--:|--:|")
    for row in rows():
        print(row)


if __name__ == "__main__":
    main()
