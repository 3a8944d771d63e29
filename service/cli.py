"""The command `camwright`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import cleandoc
from typing import Annotated, Any

import typer

from service.commands import questions
from service.commands.export import export
from service.commands.serve import serve
from service.commands.sweep import sweep
from service.commands.terminal import out
from synthesis.design.identity import ENGINE_NUMBER, engine_version

ROOT = """Cam design by optimisation, with proofs: as a service, or one question at a time.

A question is a JSON file in the form of the service's request bodies; GET /docs and the files of
openapi/examples show it. Units are in the names of its fields: mm, deg, rpm, s, and in results
mm/s, mm/s², mm/s³, deg/s and so on for followers on arms.

Begin with
  camwright design openapi/examples/example-13-6-sized.json --out results
  camwright costs results/design.json
  camwright serve

Exit codes: 0 done; 1 the service cannot start; 2 the question is invalid, a file cannot be read
or written, or a service refuses it; 3 answered, with a negative result (no cam fits, a limit is
broken, a certificate is contradicted, items failed); 130 stopped by Ctrl-C.

Environment: CAMWRIGHT_URL is a service that design, analyse, cam-set, read-back, linkage and
sweep ask instead of computing here; CAMWRIGHT_TIME_BUDGET_S is the time in seconds that one
question may take here."""
COMMANDS: Mapping[str, Callable[..., Any]] = {
    "design": questions.design,
    "analyse": questions.analyse,
    "cam-set": questions.cam_set,
    "sweep": sweep,
    "spatial": questions.spatial,
    "costs": questions.costs,
    "confirm": questions.confirm,
    "proof": questions.proof,
    "export": export,
    "read-back": questions.read_back,
    "respond": questions.respond,
    "linkage": questions.linkage,
    "serve": serve,
}


def help_text(text: str) -> str:
    """A docstring for the terminal: paragraphs are wrapped anew, those with indented lines kept."""
    parts = cleandoc(text).split("\n\n")
    examples = [any(line.startswith("  ") for line in part.splitlines()) for part in parts]
    return "\n\n".join(
        f"\b\n{part}" if example else part.replace("\n", " ")
        for part, example in zip(parts, examples, strict=True)
    )


app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
HELP = {name: help_text(command.__doc__ or "") for name, command in COMMANDS.items()}
for name, command in COMMANDS.items():
    app.command(name, help=HELP[name])(command)


def _version(wanted: bool) -> None:
    if wanted:
        out.print(f"camwright {engine_version()}, engine {ENGINE_NUMBER}")
        raise typer.Exit


@app.callback(help=help_text(ROOT))
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
