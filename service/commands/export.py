"""`camwright export`: files of one cam, chosen and sampled as wanted.

The options are those of the formats, each once: a format that is added brings its own along. So
that `--help` need not load every format, `make openapi` writes them to a file.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import typer

from service.commands.terminal import save, stop

if TYPE_CHECKING:
    from synthesis.exporters import Exporter

OPTIONS = Path(__file__).resolve().parents[1] / "assets" / "export-options.json"
TYPES: Mapping[str, type] = {"number": float, "integer": int, "boolean": bool}


class Part(StrEnum):
    """What of a cam."""

    profile = "profile"
    motion = "motion"
    solid = "solid"
    picture = "picture"


def formats_by_part() -> Mapping[str, Mapping[str, Exporter[Any]]]:
    """All formats of a design."""
    from service.workers.tasks import DESIGN_FORMATS
    from synthesis.exporters import PICTURES

    return {**DESIGN_FORMATS, Part.picture: PICTURES}


def export(
    design: Annotated[
        Path, typer.Argument(help="design.json, or a DesignSpec or example to size first; or -.")
    ],
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
    from service.commands.answering import design_of
    from synthesis.errors import CamwrightError

    known = formats_by_part()[part]
    for name in formats:
        if name not in known:
            stop(f"--format {name}: a {part} is written as {', '.join(known)}.")
    given = {name: value for name, value in chosen.items() if value is not None}
    try:
        options = {name: _options(known[name], given) for name in formats}
        cam = design_of(design)
        if not cam.motion and not all(known[name].without_cam for name in formats):
            stop(f"{design}: no cam fits its limits, so there is nothing to export.")
        stem = "" if part is Part.picture else f"{given.get('curve', part)}."
        files = {f"{stem}{name}": known[name].write(cam, options[name]) for name in formats}
    except CamwrightError as error:
        stop(str(error))
    save(files, out_dir)


def _options(exporter: Exporter[Any], given: Mapping[str, Any]) -> Any:
    from synthesis.exporters import form

    fields = form(exporter.options).model_fields
    for name in given:
        if name not in fields:
            known = ", ".join(f"--{each.replace('_', '-')}" for each in fields)
            stop(f"--{name.replace('_', '-')}: {exporter.name} has no such option. It has {known}.")
    return exporter.options(**given)


def export_options() -> dict[str, dict[str, Any]]:
    """Every option of any format once: its type or its choices, and its meaning."""
    from synthesis.exporters import form

    options: dict[str, dict[str, Any]] = {}
    for formats in formats_by_part().values():
        for exporter in formats.values():
            fields = form(exporter.options).model_fields
            own = {name: (field.annotation, field.description) for name, field in fields.items()}
            options = {
                n: {**_shape(kind), "help": text} for n, (kind, text) in own.items()
            } | options
    return options


def _shape(kind: Any) -> dict[str, Any]:
    """A type in words, that of an option which may be None without None."""
    members = [each for each in get_args(kind) if each is not type(None)]
    if all(isinstance(each, str) for each in members) and members:
        return {"choices": members}
    plain = members[0] if members else kind
    return {"type": next(word for word, each in TYPES.items() if each is plain)}


def _signature() -> inspect.Signature:
    """The signature of the command: its own options, and every option of any format once.

    None is the format's own default.
    """
    own = inspect.signature(export, eval_str=True)
    known = json.loads(OPTIONS.read_text(encoding="utf-8"))
    options = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=None,
            annotation=Annotated[_type(each) | None, typer.Option(help=each["help"])],
        )
        for name, each in known.items()
    ]  # fmt: skip
    named = [each for each in own.parameters.values() if each.kind is not each.VAR_KEYWORD]
    return own.replace(parameters=[*named, *options])


def _type(option: Mapping[str, Any]) -> Any:
    return Literal[tuple(option["choices"])] if "choices" in option else TYPES[option["type"]]


# What the terminal knows of the command.
export.__signature__ = _signature()  # type: ignore[attr-defined]
export.__annotations__ = {
    each.name: each.annotation for each in inspect.signature(export).parameters.values()
}
