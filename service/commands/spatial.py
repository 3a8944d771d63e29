"""`camwright spatial`: one spatial cam and its files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.commands.requests import Url, answer
from service.commands.tables import spatial_table
from service.commands.terminal import AsJson, out, print_json, print_tables, read_spec, save
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.spec import SpatialCamSpec


def spatial(
    spec: Annotated[Path, typer.Argument(help="File with a SpatialCamSpec, or a worked example.")],
    out_dir: Annotated[
        Path | None,
        typer.Option("--out", help="Folder for spatial.json and the files; left out: none."),
    ] = None,
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Design one spatial cam: its walls, what they do and where; write its files."""
    found = _design(read_spec(spec, SpatialCamSpec), spec, url)
    if as_json:
        print_json(found)
    else:
        out.print(spatial_table.headline(found))
        print_tables(spatial_table.tables(found), spatial_table.WIDTH)
    if out_dir is not None:
        files = _files(found)
        save(files, out_dir)
        if not as_json:
            out.print(f"Written to {out_dir}: {', '.join(files)}")
    if found.status == "infeasible":
        raise typer.Exit(3)


def _design(question: SpatialCamSpec, path: Path, url: str | None) -> SpatialDesign:
    def work(deadline: float) -> SpatialDesign:
        from synthesis.machines.spatial.pipeline import synthesise_spatial

        return synthesise_spatial(question, deadline=deadline)

    return answer(url, path, SpatialDesign, lambda client: client.spatial_cam(question), work)


def _files(found: SpatialDesign) -> dict[str, bytes]:
    """All usual files of the cam; of an infeasible one the answer alone."""
    from synthesis.machines.spatial.files import FORMATS, formats_of

    files = {"spatial.json": found.model_dump_json(indent=1).encode()}
    if found.status == "infeasible":
        return files
    for name in formats_of(found.machine):
        if FORMATS[name].usual:
            files[name] = FORMATS[name].write(found, FORMATS[name].options())
    return files
