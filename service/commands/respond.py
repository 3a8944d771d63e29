"""`camwright respond`: what an elastic follower train does on a cam, and its files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from service.commands.requests import Url, answer
from service.commands.terminal import out, read_spec, save
from synthesis.machines.dynamics import TrainResponse, TrainSpec


def respond(
    spec: Annotated[Path, typer.Argument(help="File with a TrainSpec, or a worked example.")],
    out_dir: Annotated[
        Path | None, typer.Option("--out", help="Folder for the files; none are written without.")
    ] = None,
    url: Url = None,
) -> None:
    """Say what an elastic follower train does on a cam."""
    found = _response(read_spec(spec, TrainSpec), spec, url)
    modes = ", ".join(
        f"{mode.natural_frequency_hz:.4g} Hz (ζ {mode.damping_ratio:.3g})" for mode in found.modes
    )
    out.print(f"Modes: {modes}")
    out.print(_table(found))
    if found.float_onset_rpm is not None:
        out.print(f"Contact is lost from {found.float_onset_rpm:.4g} rpm on.")
    if out_dir is not None:
        files = _files(found)
        save(files, out_dir)
        out.print(f"Written to {out_dir}: {', '.join(files)}")


def _table(found: TrainResponse) -> Table:
    table = Table(title="Periodic response", title_justify="left", box=SIMPLE_HEAD)
    columns = ("rpm", "output error mm", "left in dwells mm", "contact force N", "")
    for name in columns:
        table.add_column(name, justify="right", no_wrap=True)
    for each in found.speeds:
        error, force = each.output_error_min.value, each.contact_force_min_n.value
        table.add_row(
            f"{each.speed_rpm:g}",
            f"{error:.4g} to {each.output_error_max.value:.4g}",
            ", ".join(f"{dwell.amplitude:.3g}" for dwell in each.dwells),
            f"{force:.4g} to {each.contact_force_max_n.value:.4g}",
            "FLOATS" if each.floats else "",
        )
    return table


def _files(found: TrainResponse) -> dict[str, bytes]:
    from synthesis.machines.dynamics.files import TRAIN_FILES

    files = {"train-response.json": found.model_dump_json(indent=1).encode()}
    made = (file for file in TRAIN_FILES if file.usual)
    return files | {file.name: file.write(found, file.options()) for file in made}


def _response(question: TrainSpec, path: Path, url: str | None) -> TrainResponse:
    def work(deadline: float) -> TrainResponse:
        from synthesis.studies.train_response import respond

        return respond(question, deadline=deadline)

    budget_s = question.time_budget_s
    return answer(
        url, path, TrainResponse, lambda client: client.train_response(question), work, budget_s
    )
