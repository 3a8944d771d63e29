"""`camwright linkage`: a linkage of any kind, and its files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from service.commands.requests import Url, answer
from service.commands.terminal import out, read_spec, save, stop
from synthesis.design.design import Relaxation
from synthesis.machines.linkages import LINKAGES, Linkage


def linkage(
    kind: Annotated[str, typer.Argument(help=f"Which kind: {', '.join(LINKAGES)}.")],
    spec: Annotated[Path, typer.Argument(help="File with its spec, or a worked example.")],
    out_dir: Annotated[
        Path, typer.Option("--out", help="Folder for the results; made where it is missing.")
    ] = Path(),
    url: Url = None,
) -> None:
    """Analyse or size a linkage; write the answer, tables, diagrams and animations."""
    known = LINKAGES.get(kind)
    if known is None:
        stop(f"{kind} is not a kind of linkage. There are {', '.join(LINKAGES)}.")
    found = _answer(known, read_spec(spec, known.spec), spec, url)
    summary = known.summary(found)
    out.print(
        ", ".join([found.status, *(f"{name} {value:.6g}" for name, value in summary.items())])
    )
    for line in _conflicts(found):
        out.print(line)
    files = {"linkage.json": found.model_dump_json(indent=1).encode()}
    if summary:
        from synthesis.machines.linkages.files import LINKAGE_FILES

        made = LINKAGE_FILES[kind].values()
        wanted = (file for file in made if file.usual and file.suits(found))
        files |= {file.name: file.write(found, file.options()) for file in wanted}
    save(files, out_dir)
    out.print(f"Written to {out_dir}: {', '.join(files)}")
    if found.status == "infeasible":
        raise typer.Exit(3)


def _conflicts(found: Any) -> list[str]:
    """What conflicts in an infeasible answer, a line each."""
    conflict = getattr(found, "conflict", None)
    changes: list[Relaxation] = [] if conflict is None else conflict.relaxations
    limits = [f"  {each.limit}: {each.requested:g} requested, {each.needed:.6g} {each.unit} needed"
            for each in changes if each.needed is not None]  # fmt: skip
    poses = [pose for pose in getattr(found, "poses", []) if not pose.reachable]
    return [*limits, *(f"  {pose.name or 'pose'}: {pose.note}" for pose in poses)]


def _answer(kind: Linkage, question: Any, path: Path, url: str | None) -> Any:
    return answer(
        url, path, kind.answer, lambda client: client.linkage(kind.name, question),
        lambda deadline: kind.solve(question, deadline), question.time_budget_s,
    )  # fmt: skip
