"""`camwright sweep`: many designs out of one, here or by a service, with progress and files."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from service.commands.terminal import Folder, SpecFile, Url, save, say, stop

if TYPE_CHECKING:
    from rich.progress import Progress

    from service.client import Client

FILES = ("items.csv", "items.parquet")
STORE = "sweeps.db"  # the finished items of a sweep that is computed here


def sweep(spec: SpecFile, out_dir: Folder = None, url: Url = None) -> None:
    """Run a sweep: many designs from one base spec, over any of its fields.

    Writes sweep.json and the table items.csv, and with an optional part (170 MB; pip install
    'camwright[parquet]') items.parquet: one row an item, units in the names of the columns.
    Computed here, finished items are kept in the folder of the results, and the same command
    continues a stopped sweep; a service keeps them itself.

      camwright sweep rollers-and-laws --out results
      camwright sweep sweep.json --out results --url http://127.0.0.1:8000

    Exit codes: 0 all items have an answer; 2 the question is invalid; 3 stopped, or items failed;
    130 Ctrl-C, with what is done kept.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from service.client import Client
    from service.client.progress import as_text
    from service.commands.answering import CONTINUES, read_spec, report_errors, valid_address
    from synthesis.studies.sweeps import SweepSpec

    columns = (
        TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:3.0f} %"),
        TextColumn("{task.fields[text]}"), TimeRemainingColumn(),
    )  # fmt: skip
    question, folder = read_spec(spec, SweepSpec), out_dir or Path()
    kept = "Finished items are kept; the same command continues the sweep."
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with (
            report_errors(spec, url, CONTINUES if url else kept),
            nullcontext(valid_address(url)) if url else own_service(folder) as address,
            Client(address) as client,
            Progress(*columns, console=Console(stderr=True)) as progress,
        ):
            ended = _watch(client, client.sweep(question), progress)
            files = [name for name in FILES if _download(client, ended, name, folder, progress)]
    except OSError as error:
        stop(f"{folder} cannot be written to: {error.strerror}.")
    say(as_text(ended))
    document = json.dumps(ended, indent=1, ensure_ascii=False).encode()
    save({"sweep.json": document}, folder, ["sweep.json", *files])
    if ended["state"] != "successful":
        raise typer.Exit(3)


@contextmanager
def own_service(folder: Path) -> Iterator[str]:
    """A service in this process, on a loopback port, that keeps its sweeps in a folder."""
    from service.settings import listening_socket, settings_from
    from service.workers import prefork

    store = f"sqlite:///{folder.resolve() / STORE}"
    settings = settings_from(host="127.0.0.1", port=0, database_url=store)
    if settings.scheduler is None:
        prefork.start_fork_server()
    import uvicorn

    from service.app import create_app
    from service.server import open_database, server_config
    from service.wire.logs import configure_logs

    configure_logs("error")
    open_database(settings).dispose()
    app, listener = create_app(settings), listening_socket(settings)
    server = uvicorn.Server(server_config(app, settings))
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
    from service.client import Refused

    bar = progress.add_task(name, total=None, text="")

    def update(done: int, total: int | None) -> None:
        progress.update(bar, completed=done, total=total or done, text=f"{done / 1e3:.0f} kB")

    try:
        client.download(ended["links"][name], folder / name, progress=update)
    except Refused as error:
        if error.kind != "not-installed":
            raise
        progress.update(bar, visible=False)
        return False
    return True
