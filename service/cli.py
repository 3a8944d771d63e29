"""The command `camwright`.

What `--help` and completion need is imported here, and nothing heavier: the commands import the
core and the service when they run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import cleandoc, signature
from typing import Annotated, Any

import typer

from service.commands import questions
from service.commands.admin import ADMIN
from service.commands.admin import app as admin
from service.commands.examples import examples
from service.commands.export import export
from service.commands.keys import KEYS
from service.commands.keys import app as keys
from service.commands.serve import serve
from service.commands.sweep import sweep
from service.commands.terminal import say, with_key

ROOT = """Cam design by optimisation, with proofs: as a service, or one question at a time.

A question is a JSON file in the form of the service's request bodies, or the name of a worked
example; `camwright examples` lists these and prints them. Units are in the names of its fields:
mm, deg, rpm, s, and in results mm/s, mm/s², mm/s³, deg/s and so on for followers on arms.

Begin with
  camwright design example-13-6-sized --out results
  camwright costs results/design.json
  camwright serve

In place of a file, - is standard input: a question a line, or written over several lines. Each
answer is then a line of JSON, in the order of the questions; one that has none is a problem
document (RFC 9457), as the service sends it, whose `status` is a number and `detail` says why:
  camwright design - < specs.jsonl | jq .dimensions
  camwright design - < specs.jsonl | camwright costs -

`camwright --install-completion` makes the shell complete commands, options and examples.

Exit codes: 0 done; 1 the service cannot start; 2 the question is invalid, a file cannot be read
or written, or a service refuses it; 3 answered, with a negative result (no cam fits, a limit is
broken, a certificate is contradicted, items failed); 130 stopped by Ctrl-C. Of several questions
on standard input: 2 where one is 2, else 3 where one is 3.

Environment: CAMWRIGHT_URL is a service that design, analyse, cam-set, read-back, spatial, respond,
linkage and sweep ask instead of computing here, CAMWRIGHT_KEY is their key to it, where it asks
for one (`camwright keys --help`); CAMWRIGHT_TIME_BUDGET_S is the time in seconds
that one question may take here."""
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
    "examples": examples,
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


# Plain help: that of rich takes three times as long to load as all else here.
app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None)
HELP = {name: help_text(command.__doc__ or "") for name, command in COMMANDS.items()}
for name, command in COMMANDS.items():
    offered = with_key(command) if "url" in signature(command).parameters else command
    app.command(name, help=HELP[name], short_help=HELP[name].partition("\n")[0])(offered)
for name, group, text in (("keys", keys, KEYS), ("admin", admin, ADMIN)):
    HELP[name] = help_text(text)
    app.add_typer(group, name=name, help=HELP[name], short_help=HELP[name].partition("\n")[0])
    for each in group.registered_commands:
        each.help = help_text(getattr(each.callback, "__doc__", None) or "")
        each.short_help = each.help.partition("\n")[0]


def _version(wanted: bool) -> None:
    if wanted:
        from synthesis.design.identity import ENGINE_NUMBER, engine_version

        say(f"camwright {engine_version()}, engine {ENGINE_NUMBER}")
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
