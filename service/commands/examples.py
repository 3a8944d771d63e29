"""`camwright examples`: the worked examples that an installation brings along."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from service.commands.terminal import say, stop
from service.contract.examples import example_path, example_paths

COMMANDS = {
    "": "design",
    "analyses": "analyse",
    "cam-sets": "cam-set",
    "linkages": "linkage",
    "profile-analyses": "read-back",
    "spatial-cams": "spatial",
    "sweeps": "sweep",
    "train-responses": "respond",
}
"""Which command answers those of a folder."""


def examples(
    name: Annotated[
        str | None, typer.Argument(help="Print the question of this one.", show_default=False)
    ] = None,
) -> None:
    """List the worked examples, by the command that answers them, or print one.

    A name stands for the file in every command: camwright design p2-sized. Printed, a question is
    the beginning of one of your own; its lengths are in mm, its angles in deg.

      camwright examples
      camwright examples p2-sized > spec.json

    Exit codes: 0 done; 2 there is none of this name.
    """
    if name is not None:
        path = example_path(name)
        if path is None:
            stop(f"There is no worked example {name}: camwright examples lists them.")
        value = json.loads(path.read_text(encoding="utf-8"))["value"]
        say(json.dumps(value, indent=1, ensure_ascii=False))
        return
    paths, heading = example_paths(), ""
    wide = max(map(len, paths))
    for known, (place, path) in paths.items():
        folder, _, kind = place.partition("/")
        title = f"camwright {COMMANDS[folder]} {kind}".strip()
        if title != heading:
            say(f"{title}:")
            heading = title
        say(f"  {known:{wide}}  {json.loads(path.read_text(encoding='utf-8'))['summary']}")
