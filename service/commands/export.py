"""`camwright export`: files of one cam, chosen and sampled as wanted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
    PROFILE_FORMATS,
    Exporter,
    MotionOptions,
    ProfileOptions,
)
from synthesis.spec import DesignSpec


class Part(StrEnum):
    """What of a cam."""

    profile = "profile"
    motion = "motion"


FORMATS: Mapping[Part, Mapping[str, Exporter[Any]]] = {
    Part.profile: PROFILE_FORMATS,
    Part.motion: MOTION_FORMATS,
}
OPTIONS: Mapping[Part, Callable[..., Any]] = {
    Part.profile: ProfileOptions,
    Part.motion: MotionOptions,
}


def export(
    design: Annotated[Path, typer.Argument(help="design.json, or a DesignSpec to size first.")],
    formats: Annotated[
        list[str], typer.Option("--format", help="csv, txt, …; may be repeated.")
    ] = ["csv"],  # noqa: B006 (never changed)
    part: Annotated[Part, typer.Option(help="Its profile or its motion.")] = Part.profile,
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
) -> None:
    """Write files of one cam: of a design that was kept, or of a spec, sized now."""
    known = FORMATS[part]
    for name in formats:
        if name not in known:
            stop(f"--format {name}: a {part} is written as {', '.join(known)}.")
    try:
        dense = {} if points_per_degree is None else {"points_per_degree": points_per_degree}
        placed = {"tolerance_um": tolerance_um, "curve": curve, "turn_deg": turn_deg, "z_mm": z_mm}
        options = OPTIONS[part](**dense, **({} if part is Part.motion else placed))
        found = _design(design)
        if not found.motion:
            stop(f"{design}: no cam fits its limits, so there is nothing to export.")
        stem = curve if part is Part.profile else str(part)
        files = {f"{stem}.{name}": known[name].write(found, options) for name in formats}
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
