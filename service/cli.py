"""The command `camwright`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any

import typer

from service.commands import manual
from service.commands.analyse import analyse
from service.commands.cam_set import cam_set
from service.commands.confirm import confirm
from service.commands.costs import costs
from service.commands.design import design
from service.commands.export import export
from service.commands.linkage import linkage
from service.commands.read_back import read_back
from service.commands.respond import respond
from service.commands.serve import serve
from service.commands.spatial import spatial
from service.commands.sweep import sweep
from service.commands.terminal import out
from synthesis.design.identity import ENGINE_NUMBER, engine_version

COMMANDS: Mapping[str, Callable[..., Any]] = {
    "design": design,
    "analyse": analyse,
    "cam-set": cam_set,
    "sweep": sweep,
    "spatial": spatial,
    "costs": costs,
    "confirm": confirm,
    "export": export,
    "read-back": read_back,
    "respond": respond,
    "linkage": linkage,
    "serve": serve,
}
app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
for name, command in COMMANDS.items():
    app.command(name, help=manual.HELP[name])(command)


def _version(wanted: bool) -> None:
    if wanted:
        out.print(f"camwright {engine_version()}, engine {ENGINE_NUMBER}")
        raise typer.Exit


@app.callback(help=manual.ROOT)
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print it and stop.")
    ] = False,
) -> None:
    return None


def main() -> None:
    """Entry point."""
    app()


if __name__ == "__main__":
    main()
