"""`camwright export`: files of one cam, chosen and sampled as wanted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from service.body import parsed
from service.errors import ServiceError
from service.terminal import out, read_spec, save, stop, synthesise, synthesised
from synthesis.design import Design
from synthesis.errors import CamwrightError
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    Exporter,
    MotionOptions,
    PictureOptions,
    ProfileOptions,
)
from synthesis.spec import DesignSpec


class Part(StrEnum):
    """What of a cam."""

    profile = "profile"
    motion = "motion"
    picture = "picture"


FORMATS: Mapping[Part, Mapping[str, Exporter[Any]]] = {
    Part.profile: PROFILE_FORMATS,
    Part.motion: MOTION_FORMATS,
    Part.picture: PICTURES,
}
OPTIONS: Mapping[Part, type[Any]] = {
    Part.profile: ProfileOptions,
    Part.motion: MotionOptions,
    Part.picture: PictureOptions,
}


def export(
    design: Annotated[Path, typer.Argument(help="design.json, or a DesignSpec to size first.")],
    formats: Annotated[
        list[str], typer.Option("--format", help="csv, contact.svg, …; may be repeated.")
    ] = ["csv"],  # noqa: B006 (never changed)
    part: Annotated[
        Part, typer.Option(help="Its profile, its motion, or a picture.")
    ] = Part.profile,
    out_dir: Annotated[Path, typer.Option("--out", help="Folder for the files.")] = Path(),
    points_per_degree: Annotated[
        float | None, typer.Option(help="Points per degree of cam angle.")
    ] = None,
    tolerance_um: Annotated[
        float | None, typer.Option(help="Chord tolerance [µm]; decides instead of the points.")
    ] = None,
    curve: Annotated[str, typer.Option(help="profile, pitch, inner, counter, …")] = "profile",
    turn_deg: Annotated[float, typer.Option(help="Turn about the cam's axis [deg].")] = 0.0,
    z_mm: Annotated[float | None, typer.Option(help="Position along the axis [mm].")] = None,
    theme: Annotated[str, typer.Option(help="Of drawings: auto, light, dark, print.")] = "auto",
) -> None:
    """Write files of one cam: of a design that was kept, or of a spec, sized now."""
    known = FORMATS[part]
    for name in formats:
        if name not in known:
            stop(f"--format {name}: a {part} is written as {', '.join(known)}.")
    try:
        given = {
            "points_per_degree": points_per_degree, "tolerance_um": tolerance_um, "curve": curve,
            "turn_deg": turn_deg, "z_mm": z_mm, "theme": theme,
        }  # fmt: skip
        taken = {each.name for each in fields(OPTIONS[part])}
        chosen = {k: v for k, v in given.items() if k in taken and v is not None}
        options = OPTIONS[part](**chosen)
        found = _design(design)
        if not found.motion and not all(known[name].without_cam for name in formats):
            stop(f"{design}: no cam fits its limits, so there is nothing to export.")
        stem = {Part.profile: f"{curve}.", Part.motion: "motion."}.get(part, "")
        files = {f"{stem}{name}": known[name].write(found, options) for name in formats}
    except CamwrightError as error:
        stop(str(error))
    save(files, out_dir)
    out.print(f"Written to {out_dir}: {', '.join(files)}")


def _design(path: Path) -> Design:
    """As it stands in the file, or sized from the spec that does."""
    try:
        document = parsed(path.read_bytes())
    except (OSError, ServiceError):
        document = None  # told when it is read as a spec
    if isinstance(document, dict) and "certificate" in document:
        return read_spec(path, Design)
    found: Design = synthesised(read_spec(path, DesignSpec), synthesise)
    return found
