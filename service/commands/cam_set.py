"""`camwright cam-set`: the cams of one shaft and their files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.commands.requests import Url, answer
from service.commands.terminal import out, read_spec, save
from synthesis.design.cam_set import CamSet
from synthesis.spec.cam_set import CamSetSpec


def cam_set(
    spec: Annotated[Path, typer.Argument(help="File with a CamSetSpec, or a worked example.")],
    out_dir: Annotated[
        Path, typer.Option("--out", help="Folder for the results; made where it is missing.")
    ] = Path(),
    url: Url = None,
) -> None:
    """Size the cams of one shaft; write the set, its timing and a folder for each cam."""
    from synthesis.exporters.bundle import BundleOptions, bundle_files

    found = _cam_set(read_spec(spec, CamSetSpec), spec, url)
    out.print(f"{found.status}, {1e3 * found.seconds:.0f} ms: {len(found.cams)} cams on one shaft")
    for cam in found.cams:
        sizes = ", ".join(f"{name} {value:.4f}" for name, value in cam.design.dimensions.items())
        out.print(
            f"  {cam.name}: {cam.design.status}, phase {cam.phase_deg:g}°, keyway at "
            f"{cam.keyway_deg:g}°{': ' if sizes else ''}{sizes}"
        )
    files = {"cam-set.json": found.model_dump_json(indent=1).encode()}
    if found.has_cams:
        files = dict(bundle_files(found, BundleOptions()))
    save(files, out_dir)
    out.print(f"Written to {out_dir}: {len(files)} files")
    if found.status == "infeasible":
        raise typer.Exit(3)


def _cam_set(question: CamSetSpec, path: Path, url: str | None) -> CamSet:
    def work(deadline: float) -> CamSet:
        from synthesis.studies.cam_set import synthesise_set

        return synthesise_set(question, deadline=deadline)

    return answer(
        url, path, CamSet, lambda client: client.cam_set(question), work, question.time_budget_s
    )
