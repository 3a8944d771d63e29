"""`camwright sweep`: many designs out of one, here or by a service, with progress and files."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import (
    BarColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)

from service.client import Client, Refused
from service.client.download import Told
from service.commands.asking import STAYS, Url, checked, refusals
from service.commands.terminal import err, out, read_spec, save, stop
from service.listening import bound
from service.settings import settings_from
from service.workers import forks
from synthesis.sweeps import SweepSpec

FILES = ("items.csv", "items.parquet")
STORE = "sweeps.db"  # what a sweep here has done so far, in the folder of its results


def sweep(
    spec: Annotated[Path, typer.Argument(help="File with a SweepSpec, or a worked example.")],
    out_dir: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path(),
    url: Url = None,
) -> None:
    """Run a sweep; write sweep.json and its table. Stopped or killed, it goes on when asked again.

    Here its progress is kept in the folder of the results, by a service there.
    """
    asked = read_spec(spec, SweepSpec)
    kept = "What is done is kept; the same command joins it again."
    try:
        out_dir.mkdir(parents=True, exist_ok=True)
        with (
            refusals(spec, url, STAYS if url else kept),
            _at(url, out_dir) as address,
            Client(address) as client,
            _progress() as progress,
        ):
            over = _done(client, client.sweep(asked), progress)
            files = [name for name in FILES if _fetched(client, over, name, out_dir, progress)]
    except OSError as error:
        stop(f"{out_dir} cannot be written to: {error.strerror}.")
    save({"sweep.json": json.dumps(over, indent=1, ensure_ascii=False).encode()}, out_dir)
    counts = over["counts"]
    told = ", ".join(f"{counts[name]} {name}" for name in list(counts)[2:] if counts[name])
    out.print(f"{over['state']}: {counts['done']} of {counts['items']} items, {told}")
    out.print(f"Written to {out_dir}: {', '.join(['sweep.json', *files])}")
    if over["state"] != "successful":
        raise typer.Exit(3)


def _at(url: str | None, folder: Path) -> AbstractContextManager[str]:
    """Address of the service to ask: the one named, or one of our own."""
    return own_service(folder) if url is None else nullcontext(checked(url))


@contextmanager
def own_service(folder: Path) -> Iterator[str]:
    """A service in this process, on a loopback port, that keeps its sweeps in a folder."""
    store = f"sqlite:///{folder.resolve() / STORE}"
    settings = settings_from(host="127.0.0.1", port=0, database_url=store)
    if settings.scheduler is None:
        forks.prepare()
    import uvicorn

    from service.app import create_app
    from service.run import web
    from service.wire.observe import configure_logs

    configure_logs("error")
    app, listening = create_app(settings), bound(settings)
    server = uvicorn.Server(web(app))
    running = threading.Thread(target=lambda: asyncio.run(server.serve([listening])))
    running.start()
    try:
        while not server.started:
            running.join(0.02)
            if not running.is_alive():
                stop("The workers could not be started; see above.")
        yield f"http://127.0.0.1:{listening.getsockname()[1]}"
    finally:
        server.should_exit = True
        running.join()
        listening.close()


def _progress() -> Progress:
    return Progress(
        TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:3.0f} %"),
        TextColumn("{task.fields[told]}"), TimeRemainingColumn(), console=err,
    )  # fmt: skip


def _done(client: Client, sweep: dict[str, Any], progress: Progress) -> dict[str, Any]:
    """Watch it to its end."""
    bar = progress.add_task("items", total=sweep["counts"]["items"], told="")
    for event in client.watch(sweep["id"], items=False):
        counts, rate = event.data["counts"], event.data["rate_per_s"]
        speed = "" if rate is None else f", {rate:.1f}/s"
        told = f"{counts['done']}/{counts['items']}{speed}"
        progress.update(bar, completed=counts["done"], told=told)
    return client.get(sweep["links"]["self"])


def _fetched(
    client: Client, over: dict[str, Any], name: str, folder: Path, progress: Progress
) -> bool:
    """A table of it; False where the service does not write this format."""
    bar = progress.add_task(name, total=None, told="")
    try:
        client.download(over["links"][name], folder / name, told=_telling(progress, bar))
    except Refused as error:
        if error.kind != "format-missing":
            raise
        progress.update(bar, visible=False)
        return False
    return True


def _telling(progress: Progress, bar: TaskID) -> Told:
    def told(done: int, total: int | None) -> None:
        progress.update(bar, completed=done, total=total or done, told=f"{done / 1e3:.0f} kB")

    return told
