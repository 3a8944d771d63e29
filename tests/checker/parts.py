"""What each part of the checker is for: python -m tests.checker.parts FILE....

Of every part its lines, and how many proven claims of some proof files it is run for: claims about
their cams, and bounds (or infeasible answers).
"""

import argparse
import ast
from collections import Counter
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

from synthesis.pipeline.proof_file.checker import checker, checker_path

PARTS = {  # by its functions; those of a class as Class.function
    "reading numbers and objects": "number once read get numbers whole kind_of range_of choose",
    "the question": "turned Segment.__init__ Question.__init__ Question.prime Question.smaller "
    "Question.highest",
    "windows and points": "Segment.bounds",
    "widths of faces": "Question.ends_of_face",
    "rows": "Question.row Question.row_of_motion Question.row_of_path Question.bends "
    "Question.bent_row scaled Segment.given",
    "laws that may overshoot": "Segment.depth",
    "sine, cosine, tangent, roots": "circle tangent floor root",
    "polynomials as enclosures": "Polynomial.raised Polynomial.__add__ Polynomial.__neg__ "
    "Polynomial.__sub__ Polynomial.__rsub__ Polynomial.__mul__ enclose enclosed halves split "
    "bernstein Piece.show Piece.root",
    "named laws": "sine parts_of given",
    "paths of arms and swinging faces": "cut waves Piece.on_arm",
    "splines and slides": "pieces_of Piece.on_slide Piece.spare Cam.__init__ Cam.check",
    "joints": "Cam.join Cam.meet",
    "limits along a path": "Cam.keep Piece.part",
    "forces": "Load.__init__ Load.along Load.on Load.stiffness Cam.press Question.row_of_force",
    "radii and self-crossing of rollers": "Cam.bend Piece.curve",
    "largest and least radii": "Cam.reach",
    "sizes": "Cam.fit",
    "mean squares": "Segment.square Question.room Piece.square Cam.mean",
    "half-planes": "half_plane remainder least reach exclude",
    "rounds": "Question.hull Question.bend_row narrow bound_of",
    "boxes of arms": "Question.swings Question.arcs Question.swing_row Question.pivot "
    "Question.empty Question.distance_row",
    "swinging faces": "Question.face_row",
    "least durations, coming to rest": "duration rest Segment.speed",
    "claims, files, archives": "places excluded aims_of hold impose check contents",
}


def lines_of(source: str) -> dict[str, int]:
    """Lines of every function, by its name; of all others by an empty one."""
    found = Counter({"": len(source.splitlines())})
    for node in ast.parse(source).body:
        inner = node.body if isinstance(node, ast.ClassDef) else [node]
        prefix = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
        for each in inner:
            if isinstance(each, ast.FunctionDef):
                count = (each.end_lineno or each.lineno) - each.lineno + 1
                found[prefix + each.name] += count
                found[""] -= count
    return found


def marked(judge: Any, run: set[str]) -> None:
    """Let every function of a part add the part's name to a set when it is run."""
    for part, names in PARTS.items():
        for name in names.split():
            owner, _, own = name.rpartition(".")
            place = getattr(judge, owner) if owner else judge
            setattr(place, own, _marking(getattr(place, own), part, run))


def _marking(function: Callable[..., Any], part: str, run: set[str]) -> Callable[..., Any]:
    @wraps(function)
    def other(*values: Any, **named: Any) -> Any:
        run.add(part)
        return function(*values, **named)

    for name in ("cache_clear",):  # of what is derived once
        if hasattr(function, name):
            setattr(other, name, getattr(function, name))
    return other


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    judge, run, uses = checker(), set[str](), Counter[tuple[str, str]]()
    marked(judge, run)
    total = Counter[str]()
    for path in parser.parse_args().files:
        judge.spent.clear()
        body = judge.read(path.read_bytes())
        for claim in body["claims"]:
            if not claim["proven"]:
                continue
            place, asked, cam = claim["place"], body["question"], body["cam"]
            of_all = place == "infeasible" or place.startswith("objective/")
            run.clear()
            judge.circle.cache_clear()
            judge.parts_of.cache_clear()
            if of_all:
                judge.excluded(asked, place, claim, cam)
            else:
                question = judge.Question(asked, cam.get("program", ()))
                judge.Cam(question, cam).check(place)
            kind = "bounds" if of_all else "cam"
            total[kind] += 1
            uses.update((part, kind) for part in run)
    found = lines_of(checker_path().read_text("utf-8"))
    print("| part | lines | claims of the cam | bounds |\n|---|---|---|---|")
    for part, names in PARTS.items():
        count = sum(found.pop(name) for name in names.split())
        print(f"| {part} | {count} | {uses[part, 'cam']} | {uses[part, 'bounds']} |")
    print(f"| constants, tables, other helpers | {sum(found.values())} | | |")
    print(f"| all | {len(checker_path().read_text('utf-8').splitlines())} | {total['cam']} | "
          f"{total['bounds']} |")  # fmt: skip


if __name__ == "__main__":
    main()
