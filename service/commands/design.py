"""`camwright design`: one cam and its files."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from service.commands.asking import Url, asked
from service.commands.forces import force_lines
from service.commands.terminal import out, read_spec, save, synthesise, synthesised
from synthesis.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.spec import DesignSpec


def design(
    spec: Annotated[Path, typer.Argument(help="File with a DesignSpec, or a worked example.")],
    out_dir: Annotated[
        Path, typer.Option("--out", help="Folder for the results; made where it is missing.")
    ] = Path(),
    url: Url = None,
) -> None:
    """Size one cam; write design.json, its files and pictures."""
    question = read_spec(spec, DesignSpec)
    started = time.perf_counter()
    done = _done(question, spec, url)
    took = time.perf_counter() - started
    names = _write(done, out_dir)
    gap = "" if done.certificate.gap is None else f", gap {100.0 * done.certificate.gap:.2f} %"
    sizes = ", ".join(f"{name} {value:.4f}" for name, value in done.dimensions.items())
    out.print(f"{done.status}{gap}, {1e3 * took:.0f} ms: {sizes}")
    if done.forces is not None:
        for line in force_lines(done.forces):
            out.print(line)
    if done.chosen:
        told = (f"{name} {value:.6g}" for name, value in done.chosen.items())
        out.print(f"Chosen: {', '.join(told)}")
    out.print(f"Written to {out_dir}: {', '.join(names)}")
    if done.conflict is not None:
        out.print(f"These limits cannot hold together: {', '.join(done.conflict.limits)}")
        raise typer.Exit(3)


def _done(question: DesignSpec, path: Path, url: str | None) -> Design:
    if url is not None:
        return asked(url, path, Design, lambda client: client.design(question))
    found: Design = synthesised(question, synthesise)
    return found


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
