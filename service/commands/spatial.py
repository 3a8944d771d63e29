"""`camwright spatial`: one spatial cam and its files."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from service.commands.asking import Url, asked
from service.commands.showing import AsJson, as_document, widened
from service.commands.tables import spatial_table
from service.commands.terminal import out, read_spec, save, stop
from service.settings import settings_from
from synthesis.errors import CamwrightError
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.spec import SpatialCamSpec


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
    found = _done(read_spec(spec, SpatialCamSpec), spec, url)
    if as_json:
        as_document(found)
    else:
        out.print(spatial_table.headline(found))
        widened(spatial_table.tables(found), spatial_table.WIDTH)
    if out_dir is not None:
        files = _files(found)
        save(files, out_dir)
        if not as_json:
            out.print(f"Written to {out_dir}: {', '.join(files)}")
    if found.status == "infeasible":
        raise typer.Exit(3)


def _done(question: SpatialCamSpec, path: Path, url: str | None) -> SpatialDesign:
    if url is not None:
        return asked(url, path, SpatialDesign, lambda client: client.spatial_cam(question))
    from synthesis.spatial.pipeline import synthesise_spatial

    try:
        return synthesise_spatial(
            question, deadline=time.monotonic() + settings_from().budget_s(None)
        )
    except CamwrightError as error:
        stop(str(error))


def _files(found: SpatialDesign) -> dict[str, bytes]:
    """What the cam can be had as; an infeasible one as its answer alone."""
    from synthesis.spatial.files import FORMATS, formats_of

    files = {"spatial.json": found.model_dump_json(indent=1).encode()}
    if found.status == "infeasible":
        return files
    for name in formats_of(found.machine):
        if FORMATS[name].usual:
            files[name] = FORMATS[name].write(found, FORMATS[name].options())
    return files
