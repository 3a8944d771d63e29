"""`camwright linkage`: a linkage of any kind, and its files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from service.commands.asking import Url, asked
from service.commands.terminal import out, read_spec, save, stop, synthesised
from synthesis.design import Relaxation
from synthesis.linkages import LINKAGES, Linkage


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
        stop(f"{kind} is no kind of linkage here. Known: {', '.join(LINKAGES)}.")
    found = _done(known, read_spec(spec, known.spec), spec, url)
    told = known.told(found)
    out.print(", ".join([found.status, *(f"{name} {value:.6g}" for name, value in told.items())]))
    for line in _troubles(found):
        out.print(line)
    files = {"linkage.json": found.model_dump_json(indent=1).encode()}
    if told:
        from synthesis.exporters.linkages import LINKAGE_FILES

        made = LINKAGE_FILES[kind].values()
        wanted = (file for file in made if file.usual and file.suits(found))
        files |= {file.name: file.write(found, file.options()) for file in wanted}
    save(files, out_dir)
    out.print(f"Written to {out_dir}: {', '.join(files)}")
    if found.status == "infeasible":
        raise typer.Exit(3)


def _troubles(found: Any) -> list[str]:
    """Why an answer is no, a line each."""
    conflict = getattr(found, "conflict", None)
    changes: list[Relaxation] = [] if conflict is None else conflict.relaxations
    told = [f"  {each.limit}: {each.asked:g} asked, {each.needed:.6g} {each.unit} would do"
            for each in changes if each.needed is not None]  # fmt: skip
    poses = [pose for pose in getattr(found, "poses", []) if not pose.reachable]
    return [*told, *(f"  {pose.name or 'pose'}: {pose.note}" for pose in poses)]


def _done(known: Linkage, question: Any, path: Path, url: str | None) -> Any:
    if url is not None:
        return asked(url, path, known.found, lambda client: client.linkage(known.name, question))
    return synthesised(question, known.work)
