"""`camwright export`: files of one cam, chosen and sampled as wanted.

The options are those of the formats, each once: a format that is added brings its own along.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic.fields import FieldInfo

from service.commands.terminal import answer, read_spec, save, stop
from service.wire.body import parse_json
from service.wire.errors import ServiceError
from service.workers.tasks import DESIGN_FORMATS
from synthesis.design.design import Design
from synthesis.errors import CamwrightError
from synthesis.exporters import PICTURES, Exporter, form


class Part(StrEnum):
    """What of a cam."""

    profile = "profile"
    motion = "motion"
    solid = "solid"
    picture = "picture"


FORMATS: Mapping[str, Mapping[str, Exporter[Any]]] = {**DESIGN_FORMATS, Part.picture: PICTURES}


def export(
    design: Annotated[Path, typer.Argument(help="design.json, or a DesignSpec to size first.")],
    formats: Annotated[
        list[str], typer.Option("--format", help="csv, contact.svg, …; may be repeated.")
    ] = ["csv"],  # noqa: B006 (never changed)
    part: Annotated[
        Part, typer.Option(help="Its profile, its motion, the cam itself, or pictures.")
    ] = Part.profile,
    out_dir: Annotated[Path, typer.Option("--out", help="Folder for the files.")] = Path(),
    **chosen: Any,
) -> None:
    """Write files of one cam: of a design in a file, or of a question, computed now.

    Lengths in mm, angles in deg, chord tolerances in µm. Each format has options of its own; an
    unknown one is refused, with a list of those that there are.

      camwright export results/design.json --format txt --points-per-degree 10
      camwright export results/design.json --format csv --curve pitch --tolerance-um 2
      camwright export results/design.json --part motion --format svg
      camwright export results/design.json --part picture --format contact.svg

    Exit codes: 0 written; 2 no such format, option or curve, or no cam fits.
    """
    known = FORMATS[part]
    for name in formats:
        if name not in known:
            stop(f"--format {name}: a {part} is written as {', '.join(known)}.")
    given = {name: value for name, value in chosen.items() if value is not None}
    try:
        options = {name: _options(known[name], given) for name in formats}
        cam = _design(design)
        if not cam.motion and not all(known[name].without_cam for name in formats):
            stop(f"{design}: no cam fits its limits, so there is nothing to export.")
        stem = "" if part is Part.picture else f"{given.get('curve', part)}."
        files = {f"{stem}{name}": known[name].write(cam, options[name]) for name in formats}
    except CamwrightError as error:
        stop(str(error))
    save(files, out_dir)


def _options(exporter: Exporter[Any], given: Mapping[str, Any]) -> Any:
    fields = form(exporter.options).model_fields
    for name in given:
        if name not in fields:
            known = ", ".join(f"--{each.replace('_', '-')}" for each in fields)
            stop(f"--{name.replace('_', '-')}: {exporter.name} has no such option. It has {known}.")
    return exporter.options(**given)


def _signature() -> inspect.Signature:
    """The signature of the command: its own options, and every option of any format once.

    None is the format's own default.
    """
    own = inspect.signature(export, eval_str=True)
    fields: dict[str, FieldInfo] = {}
    for formats in FORMATS.values():
        for exporter in formats.values():
            fields = form(exporter.options).model_fields | fields
    shapes: dict[str, Any] = {name: field.annotation for name, field in fields.items()}
    options = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=None,
            annotation=Annotated[shapes[name] | None, typer.Option(help=field.description)],
        )
        for name, field in fields.items()
    ]  # fmt: skip
    named = [each for each in own.parameters.values() if each.kind is not each.VAR_KEYWORD]
    return own.replace(parameters=[*named, *options])


def _design(path: Path) -> Design:
    """The design in the file, or that of the spec in the file, computed now."""
    try:
        document = parse_json(path.read_bytes())
    except (OSError, ServiceError):
        document = None  # reported when it is read as a spec
    if isinstance(document, dict) and "certificate" in document:
        return read_spec(path, Design)
    design: Design = answer("designs", path)
    return design


# What the terminal knows of the command.
export.__signature__ = _signature()  # type: ignore[attr-defined]
export.__annotations__ = {
    each.name: each.annotation for each in inspect.signature(export).parameters.values()
}
