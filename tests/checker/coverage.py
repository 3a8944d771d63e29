"""What proof files cover, family by family: python -m tests.checker.coverage 2.

Of the first scenes of every family: how many of the claims about their cams are proven, how many
bounds (or infeasible answers) are, and how many of these stay below the answer's own.
"""

import argparse
from collections import Counter

from synthesis import DesignSpec, proof, synthesise
from synthesis.errors import TimeBudgetExceeded
from tests.hard.families import FAMILIES, random_scene

BUDGET_S = 10.0


def counts(family: str, scenes: int) -> Counter[str]:
    """Claims of the first scenes of a family, by kind."""
    tally = Counter[str]()
    for number in range(scenes):
        spec = DesignSpec.model_validate(
            {**random_scene(family, number), "time_budget_s": BUDGET_S}
        )
        try:
            design = synthesise(spec)
        except TimeBudgetExceeded as error:
            if error.best is None:
                continue
            design = error.best
        for claim in proof(design)["claims"]:
            of_all = claim["place"] == "infeasible" or claim["place"].startswith("objective/")
            kind = "bounds" if of_all else "claims"
            tally[kind] += 1
            tally[f"{kind} proven"] += claim["proven"]
            tally["lower"] += "note" in claim
    return tally


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=int)
    scenes = parser.parse_args().scenes
    print("| family | of the cam | bounds | below the answer's |\n|---|---|---|---|", flush=True)
    every = Counter[str]()
    for family in FAMILIES:
        tally = counts(family, scenes)
        every += tally
        print(_row(family, tally), flush=True)
    print(_row("all", every))


def _row(name: str, tally: Counter[str]) -> str:
    pairs = (f"{tally[f'{kind} proven']} of {tally[kind]}" for kind in ("claims", "bounds"))
    return f"| {name} | {' | '.join(pairs)} | {tally['lower'] or ''} |"


if __name__ == "__main__":
    main()
