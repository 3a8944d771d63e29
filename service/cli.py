"""The command `camwright`."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from service import analysis_table, confirmation_table, reading_table
from service.commands.export import export
from service.commands.sweep import sweep
from service.points_file import points_in
from service.settings import settings_from
from service.terminal import out, read_spec, save, stop, synthesise, synthesised
from synthesis.camset import CamSet
from synthesis.camset_spec import CamSetSpec
from synthesis.design import Design, engine_version
from synthesis.errors import CamwrightError
from synthesis.exporters.exporter import Exporter
from synthesis.findings import Analysis
from synthesis.spec import DesignSpec

app = typer.Typer(
    add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False,
    help="Certified cam synthesis: as a service, or one design at a time.",
)  # fmt: skip
app.command()(export)
app.command()(sweep)


def _version(wanted: bool) -> None:
    if wanted:
        out.print(f"camwright {engine_version()}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print it and stop.")
    ] = False,
) -> None:
    """Certified cam synthesis."""


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on.")] = None,
    database_url: Annotated[str | None, typer.Option(help="SQLAlchemy address.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="Dask scheduler to use.")] = None,
) -> None:
    """Start the service. What is left out comes from CAMWRIGHT_* or the defaults."""
    from service.run import serve as run

    asked = {"host": host, "port": port, "database_url": database_url, "scheduler": scheduler}
    given: dict[str, Any] = {name: value for name, value in asked.items() if value is not None}
    run(settings_from(**given))


@app.command()
def design(
    spec: Annotated[Path, typer.Argument(help="File with a DesignSpec, or a worked example.")],
    out_dir: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path(),
) -> None:
    """Synthesise one cam here, without a service; write design.json, profile.* and motion.*."""
    asked = read_spec(spec, DesignSpec)
    started = time.perf_counter()
    done: Design = synthesised(asked, synthesise)
    took = time.perf_counter() - started
    names = _write(done, out_dir)
    gap = "" if done.certificate.gap is None else f", gap {100.0 * done.certificate.gap:.2f} %"
    sizes = ", ".join(f"{name} {value:.4f}" for name, value in done.dimensions.items())
    out.print(f"{done.status}{gap}, {1e3 * took:.0f} ms: {sizes}")
    out.print(f"Written to {out_dir}: {', '.join(names)}")
    if done.conflict is not None:
        out.print(f"These limits cannot hold together: {', '.join(done.conflict.limits)}")
        raise typer.Exit(3)


@app.command()
def cam_set(
    spec: Annotated[Path, typer.Argument(help="File with a CamSetSpec, or a worked example.")],
    out_dir: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path(),
) -> None:
    """Synthesise the cams of one shaft; write the set, its timing and a folder for each cam."""
    from synthesis.exporters.bundle import BundleOptions, bundle_files
    from synthesis.set_synthesis import synthesise_set

    found: CamSet = synthesised(read_spec(spec, CamSetSpec), synthesise_set)
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


@app.command()
def analyse(
    spec: Annotated[Path, typer.Argument(help="File with a DesignSpec, or a worked example.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print the whole as JSON.")] = False,
) -> None:
    """Analyse a cam that is given in full: what it does, what it breaks, and what mends it."""
    found = _analysed(read_spec(spec, DesignSpec))
    if as_json:
        print(found.model_dump_json(indent=1))
    else:
        out.print(analysis_table.headline(found))
        out.print(analysis_table.undercut(found), analysis_table.self_crossing(found), sep="\n")
        wide = Console(highlight=False, width=max(out.width, analysis_table.WIDTH))
        for table in analysis_table.tables(found):
            wide.print(table)
    if not found.holds:
        raise typer.Exit(3)


@app.command()
def confirm(
    design: Annotated[Path, typer.Argument(help="File with a Design, as `design` writes it.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print the whole as JSON.")] = False,
) -> None:
    """Measure a finished design's certificate again, in ball arithmetic, to 25 digits."""
    from synthesis.confirmation import confirm as confirmed

    try:
        found = confirmed(read_spec(design, Design))
    except CamwrightError as error:
        stop(str(error))
    if as_json:
        print(found.model_dump_json(indent=1))
    else:
        out.print(confirmation_table.headline(found))
        wide = Console(highlight=False, width=max(out.width, confirmation_table.WIDTH))
        wide.print(confirmation_table.table(found))
    if found.verdict != "confirmed":
        raise typer.Exit(3)


@app.command()
def read_back(
    spec: Annotated[Path, typer.Argument(help="File with a MeasuredCam, points_mm or not.")],
    points: Annotated[
        Path | None, typer.Option(help="File of measured points: csv or columns x y, in mm.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the whole as JSON.")] = False,
) -> None:
    """Read the motion back from measured points of a profile."""
    from synthesis.measured import MeasuredCam
    from synthesis.measured import read_back as read

    try:
        given = None if points is None else {"points_mm": points_in(points)}
        found = read(read_spec(spec, MeasuredCam, given))
    except OSError as error:
        stop(f"{points} cannot be read: {error.strerror}.")
    except UnicodeDecodeError:
        stop(f"{points} is no text in UTF-8.")
    except CamwrightError as error:
        stop(str(error))
    if as_json:
        print(found.model_dump_json(indent=1))
        return
    out.print(reading_table.headline(found))
    wide = Console(highlight=False, width=max(out.width, analysis_table.WIDTH))
    for table in reading_table.tables(found):
        wide.print(table)


def _analysed(spec: DesignSpec) -> Analysis:
    from synthesis.analysis import analyse

    budget = settings_from().budget_s(spec.time_budget_s)
    try:
        return analyse(spec, deadline=time.monotonic() + budget)
    except CamwrightError as error:
        stop(str(error))


def _write(design: Design, folder: Path) -> list[str]:
    from synthesis.exporters import (
        MOTION_FORMATS,
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
    save(files, folder)
    return list(files)


def _usual(formats: Mapping[str, Exporter[Any]]) -> list[tuple[str, Exporter[Any]]]:
    return [(name, each) for name, each in formats.items() if each.usual]


def main() -> None:
    """Entry point."""
    app()


if __name__ == "__main__":
    main()
