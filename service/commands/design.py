"""`camwright design`: one cam and its files."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from service.commands.forces import force_lines
from service.commands.requests import Url, answer
from service.commands.terminal import out, read_spec, save
from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.spec.design_spec import DesignSpec


def design(
    spec: Annotated[Path, typer.Argument(help="File with a DesignSpec, or a worked example.")],
    out_dir: Annotated[
        Path, typer.Option("--out", help="Folder for the results; made where it is missing.")
    ] = Path(),
    url: Url = None,
) -> None:
    """Design one cam; write design.json, its files and pictures."""
    question = read_spec(spec, DesignSpec)
    started = time.perf_counter()
    found = _design(question, spec, url)
    seconds = time.perf_counter() - started
    names = _write(found, out_dir)
    gap = "" if found.certificate.gap is None else f", gap {100.0 * found.certificate.gap:.2f} %"
    sizes = ", ".join(f"{name} {value:.4f}" for name, value in found.dimensions.items())
    out.print(f"{found.status}{gap}, {1e3 * seconds:.0f} ms: {sizes}")
    if found.forces is not None:
        for line in force_lines(found.forces):
            out.print(line)
    if found.free_parameters:
        values = (f"{name} {value:.6g}" for name, value in found.free_parameters.items())
        out.print(f"Chosen: {', '.join(values)}")
    out.print(f"Written to {out_dir}: {', '.join(names)}")
    if found.conflict is not None:
        out.print(f"These limits cannot hold together: {', '.join(found.conflict.limits)}")
        raise typer.Exit(3)


def _design(question: DesignSpec, path: Path, url: str | None) -> Design:
    def work(deadline: float) -> Design:
        from synthesis.pipeline.synthesise import synthesise

        return synthesise(question, deadline=deadline)

    return answer(
        url, path, Design, lambda client: client.design(question), work, question.time_budget_s
    )


def _write(design: Design, folder: Path) -> list[str]:
    from synthesis.exporters import (
        MOTION_FORMATS,
        PICTURES,
        PROFILE_FORMATS,
        ProfileOptions,
        profiles,
    )

    files = {"design.json": design.model_dump_json(indent=1).encode()}
    if design.motion:
        for name, profile in _usual(PROFILE_FORMATS):
            for stem, curve in profiles(design).items():
                if profile.placeable or stem == "profile":  # a drawing shows every flank
                    files[f"{stem}.{name}"] = profile.write(
                        design, profile.adapted(ProfileOptions(curve=curve))
                    )
        for name, motion in _usual(MOTION_FORMATS):
            files[f"motion.{name}"] = motion.write(design, motion.options())
    for name, picture in _usual(PICTURES):
        if design.motion or picture.without_cam:
            files[name] = picture.write(design, picture.options())
    save(files, folder)
    return list(files)


def _usual(formats: Mapping[str, Exporter[Any]]) -> list[tuple[str, Exporter[Any]]]:
    return [(name, each) for name, each in formats.items() if each.usual]
