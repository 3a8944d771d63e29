"""`camwright sweep`: many designs out of one, here or by a service, with progress and files."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from service.client import Client, Refused
from service.commands.terminal import (
    CONTINUES,
    Folder,
    Url,
    err,
    out,
    read_spec,
    report_errors,
    save,
    stop,
    valid_address,
)
from service.settings import listening_socket, settings_from
from service.workers import prefork
from synthesis.studies.sweeps import SweepSpec

FILES = ("items.csv", "items.parquet")
COLUMNS = (
    TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:3.0f} %"),
    TextColumn("{task.fields[text]}"), TimeRemainingColumn(),
)  # fmt: skip
STORE = "sweeps.db"  # the finished items of a sweep that is computed here


def sweep(
    spec: Annotated[Path, typer.Argument(help="File with a SweepSpec, or a worked example.")],
    out_dir: Folder = Path(),
    url: Url = None,
) -> None:
    """Run a sweep: many designs from one base spec, over any of its fields.

    Writes sweep.json and the table items.csv (items.parquet with the package `parquet`), one row an
    item, units in the names of the columns. Computed here, finished items are kept in the folder of
    the results, and the same command continues a stopped sweep; a service keeps them itself.

      camwright sweep openapi/examples/sweeps/rollers-and-laws.json --out results
      camwright sweep sweep.json --out results --url http://127.0.0.1:8000

    Exit codes: 0 all items have an answer; 2 the question is invalid; 3 stopped, or items failed;
    130 Ctrl-C, with what is done kept.
    """
    question = read_spec(spec, SweepSpec)
    kept = "Finished items are kept; the same command continues the sweep."
    try:
        out_dir.mkdir(parents=True, exist_ok=True)
        with (
            report_errors(spec, url, CONTINUES if url else kept),
            nullcontext(valid_address(url)) if url else own_service(out_dir) as address,
            Client(address) as client,
            Progress(*COLUMNS, console=err) as progress,
        ):
            ended = _watch(client, client.sweep(question), progress)
            files = [name for name in FILES if _download(client, ended, name, out_dir, progress)]
    except OSError as error:
        stop(f"{out_dir} cannot be written to: {error.strerror}.")
    counts = ended["counts"]
    results = ", ".join(f"{counts[name]} {name}" for name in list(counts)[2:] if counts[name])
    out.print(f"{ended['state']}: {counts['done']} of {counts['items']} items, {results}")
    document = json.dumps(ended, indent=1, ensure_ascii=False).encode()
    save({"sweep.json": document}, out_dir, ["sweep.json", *files])
    if ended["state"] != "successful":
        raise typer.Exit(3)


@contextmanager
def own_service(folder: Path) -> Iterator[str]:
    """A service in this process, on a loopback port, that keeps its sweeps in a folder."""
    store = f"sqlite:///{folder.resolve() / STORE}"
    settings = settings_from(host="127.0.0.1", port=0, database_url=store)
    if settings.scheduler is None:
        prefork.start_fork_server()
    import uvicorn

    from service.app import create_app
    from service.server import check_database, server_config
    from service.wire.observe import configure_logs

    configure_logs("error")
    check_database(settings)
    app, listener = create_app(settings), listening_socket(settings)
    server = uvicorn.Server(server_config(app))
    running = threading.Thread(target=lambda: asyncio.run(server.serve([listener])))
    running.start()
    try:
        while not server.started:
            running.join(0.02)
            if not running.is_alive():
                stop("The workers could not be started; see the messages above.")
        yield f"http://127.0.0.1:{listener.getsockname()[1]}"
    finally:
        server.should_exit = True
        running.join()
        listener.close()


def _watch(client: Client, sweep: dict[str, Any], progress: Progress) -> dict[str, Any]:
    """Wait for the end of a sweep, and show its progress."""
    bar = progress.add_task("items", total=sweep["counts"]["items"], text="")
    for event in client.watch(sweep["id"], items=False):
        counts, rate = event.data["counts"], event.data["rate_per_s"]
        speed = "" if rate is None else f", {rate:.1f}/s"
        text = f"{counts['done']}/{counts['items']}{speed}"
        progress.update(bar, completed=counts["done"], text=text)
    return client.get(sweep["links"]["self"])


def _download(
    client: Client, ended: dict[str, Any], name: str, folder: Path, progress: Progress
) -> bool:
    """Download a table; False where the service cannot write this format."""
    bar = progress.add_task(name, total=None, text="")

    def update(done: int, total: int | None) -> None:
        progress.update(bar, completed=done, total=total or done, text=f"{done / 1e3:.0f} kB")

    try:
        client.download(ended["links"][name], folder / name, progress=update)
    except Refused as error:
        if error.kind != "format-missing":
            raise
        progress.update(bar, visible=False)
        return False
    return True
