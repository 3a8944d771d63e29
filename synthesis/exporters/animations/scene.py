"""A machine in motion beside its diagrams, whatever the machine is: as SVG and as a page."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from synthesis.exporters.diagrams.plot import Frame, Plot, diagram, with_range
from synthesis.exporters.diagrams.sheet import angle_axis
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing import html
from synthesis.exporters.exporter import FileFormat, asset
from synthesis.exporters.figures.machine import Moving, Tag, moving_group
from synthesis.exporters.options import Options, PictureOptions, Theme
from synthesis.numerics.piecewise import Array

Body = Callable[[Tag], list[str]]
Reading = dict[str, Any]
MACHINE = (112.0, 122.0)  # width and height of the panels [mm]
DIAGRAMS = (112.0, 122.0)  # the same of the other panel [mm]
EDGE = 8.0  # beside both [mm]
LEFT, RIGHT, TOP, HEIGHT, GAP = 15.0, 4.0, 8.0, 38.0, 11.0  # of the diagrams on their panel [mm]
TURN_S = 8.0  # what one turn takes on the screen
FULL = 360.0  # degrees in a turn
# Positions over a turn: what plays in a browser, what is stepped by half a degree.
FRAMES = {"svg": 240, "html": 720}
HEADER, FOOTER = 16.0, 8.0  # above and below the panels [mm]
Format = TypeVar("Format", bound=FileFormat[Any, Any])


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene over one turn of a shaft.

    Attributes:
        name, about: of the machine, in a line each. key: its id.
        heading: both as elements of a sheet. shaft: what the turn is of, as in ``Cam angle``.
        titles: of the two panels. described: what is seen, in a sentence.
        machine, diagrams: elements of the panels, their parts named by the tag.
        moving: everything that moves. readings: numbers that follow. decimals: of coordinates.
        rules: style of the machine's lines. footer: the line below.
    """

    name: str
    about: str
    key: str
    heading: Sequence[str]
    shaft: str
    titles: tuple[str, str]
    described: str
    machine: Body
    diagrams: Body
    moving: Sequence[Moving]
    readings: Sequence[Reading]
    decimals: int
    rules: str
    footer: str


def lasting(turn_s: float) -> str:
    """How long a turn takes, and how long it is shown."""
    return f"One turn is shown in {TURN_S:g} s; it takes {svg.figure(turn_s)} s."


def reading(name: str, title: str, unit: str, values: Array, size: float) -> Reading:
    """A number that follows the motion, rounded to four digits of its size."""
    digits = int(np.clip(3 - np.floor(np.log10(size)), 0, 9)) if size > 0.0 else 1
    rounded = [round(v, digits) if np.isfinite(v) else None for v in values.tolist()]
    return {"name": name, "title": title, "unit": unit, "digits": digits, "column": rounded}


def traced_diagrams(
    plots: Sequence[Plot],
    degrees: Array,
    values: Sequence[Array],
    grounds: Callable[[Frame], list[str]],
    shaft: str,
) -> tuple[list[Moving], Body]:
    """Diagrams below each other: their cursor and moving points, and the elements of the panel.

    Args:
        degrees, values: (n,) where the points run, values for each diagram.
        grounds: background of a diagram. shaft: name of the abscissa.
    """
    plots = [replace(plot, ends=()) for plot in plots]
    frames = [
        with_range(Frame(LEFT, TOP + k * (HEIGHT + GAP), DIAGRAMS[0] - LEFT - RIGHT, HEIGHT), plot)
        for k, plot in enumerate(plots)
    ]
    across, bottom = frames[0].x(degrees), frames[-1].bottom
    heights = {"cursor": 0.0 * across}
    heights |= {f"dot{k}": frame.y(values[k]) for k, frame in enumerate(frames)}
    points = [Moving(name, "shift", np.stack([across, y], axis=1)) for name, y in heights.items()]

    def panel(tag: Tag) -> list[str]:
        body: list[str] = []
        for frame, plot in zip(frames, plots, strict=True):
            body += [*grounds(frame), *diagram(plot, frame)]
        body += angle_axis(frames[-1], every=2, name=shaft)
        body += moving_group("cursor", tag, points, [svg.line("phase", 0.0, TOP, 0.0, bottom)])
        for k in range(len(plots)):
            body += moving_group(f"dot{k}", tag, points, [svg.circle("mark", 0.0, 0.0, 1.3)])
        return body

    return points, panel


def draw(scene: Scene, theme: Theme) -> bytes:
    """The scene as one SVG: the machine on the left, its diagrams on the right.

    CSS keyframes, no script; it stands still where less motion is asked for.
    """
    prefix = f"cw{scene.key[:8]}"
    width = 2.0 * EDGE + MACHINE[0] + DIAGRAMS[0]
    height = HEADER + max(MACHINE[1], DIAGRAMS[1]) + FOOTER

    def tag(part: str) -> str:
        return f'class="{prefix}-{part}"'

    body = [*scene.heading]
    for x, panel in ((EDGE, scene.machine), (EDGE + MACHINE[0], scene.diagrams)):
        body += [f'<g transform="translate({svg.num(x)} {svg.num(HEADER)})">', *panel(tag), "</g>"]
    body.append(svg.text("tick", EDGE, height - 3.5, scene.footer))
    rules = scene.rules + "".join(_rules(prefix, scene))
    title = f"{scene.name or scene.key} in motion"
    return svg.document(width, height, 1.0, title, scene.described, body, theme=theme, rules=rules)


def _rules(prefix: str, scene: Scene) -> Iterator[str]:
    """Keyframes of everything that moves, unless less motion is asked for."""
    decimals = scene.decimals
    yield "@media (prefers-reduced-motion:no-preference){"
    for part in scene.moving:
        total = float(part.values[-1, 0] - part.values[0, 0])
        if part.rolls and abs(total) > 1e-6:
            yield _runs(prefix, f"{part.name}-mean", TURN_S * FULL / abs(total))
            end = FULL if total > 0.0 else -FULL
            yield f"@keyframes {prefix}-{part.name}-mean{{to{{transform:rotate({end:g}deg)}}}}"
            mean = np.linspace(0.0, total, len(part.values))[:, None]
            part = replace(part, values=part.values - mean)
        yield _runs(prefix, part.name, TURN_S)
        yield f"@keyframes {prefix}-{part.name}{{{''.join(_frames(part, decimals))}}}"
    yield "}"


def _runs(prefix: str, name: str, seconds: float) -> str:
    of = f"{prefix}-{name}"
    return f".{of}{{animation:{of} {svg.num(seconds, 9)}s linear infinite}}"


def _frames(part: Moving, decimals: int) -> Iterator[str]:
    """One state after the other; those between which nothing changes are left out."""
    values = np.round(part.values, 3 if part.kind == "turn" else decimals)
    same = np.all(values[1:] == values[:-1], axis=1)
    for k, row in enumerate(values.tolist()):
        if 0 < k < len(values) - 1 and same[k - 1] and same[k]:
            continue
        if part.kind == "turn":
            state = f"rotate({svg.num(row[0])}deg)"
        else:
            state = f"translate({svg.num(row[0], decimals)}px,{svg.num(row[1], decimals)}px)"
        yield f"{svg.num(100.0 * k / (len(values) - 1))}%{{transform:{state}}}"


def play(scene: Scene, theme: Theme) -> bytes:
    """The scene as a page with controls and numbers, which needs no network."""
    name = scene.name or scene.shaft.partition(" ")[0]
    moving = [part.data(scene.decimals) for part in scene.moving]
    data = {"parts": moving, "readings": scene.readings}
    numbers = [(scene.shaft, "theta", "°")]  # that follow the motion
    numbers += [(r["title"], r["name"], r["unit"]) for r in scene.readings]
    readings = "".join(
        f'<div><dt>{title}</dt><dd><output id="{key}">&#8211;</output> {svg.unit(unit)}</dd></div>'
        for title, key, unit in numbers
    )
    body = asset("animation.html").format(
        name=html.plain(name),
        about=html.plain(scene.about),
        machine=_inline(scene.titles[0], MACHINE, scene.machine(tag)),
        diagrams=_inline(scene.titles[1], DIAGRAMS, scene.diagrams(tag)),
        shaft=scene.shaft,
        readings=f"<dl>{readings}</dl>",
        # no page takes this for elements of its own
        data=json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
    )
    sheet = svg.style(1.0, theme) + scene.rules + asset("animation.css")
    return html.page(f"{name} in motion", sheet, body, theme, asset("animation.js"))


def tag(part: str) -> str:
    """The attribute that names a part."""
    return f'data-part="{part}"'


def _inline(title: str, size: tuple[float, float], body: list[str]) -> str:
    head = f'<svg class="camwright" role="img" viewBox="0 0 {size[0]:g} {size[1]:g}">'
    return "\n".join([head, f"<title>{title}</title>", *body, "</svg>"])


def pictures(
    kind: type[Format], scene: Callable[[Any, int], Scene], title: str, purpose: str
) -> tuple[Format, Format]:
    """The animated SVG and the page of a scene, made from an answer and a number of frames."""

    def picture(answer: Any, options: PictureOptions) -> bytes:
        return draw(scene(answer, FRAMES["svg"]), options.theme)

    def page(answer: Any, options: PictureOptions) -> bytes:
        return play(scene(answer, FRAMES["html"]), options.theme)

    return (
        kind("animation.svg", title, "image/svg+xml", ".svg", picture, PictureOptions, purpose),
        kind(
            "animation.html", "Animation to play, stop and read", "text/html; charset=utf-8",
            ".html", page, PictureOptions,
            "One file that needs no network; by mouse, touch and keys.",
        ),
    )  # fmt: skip


def data(kind: type[Format], write: Callable[[Any, Options], bytes], title: str) -> Format:
    """The animation as JSON, which ``write`` makes; written only where it is named."""
    return kind(
        "animation.json", title, "application/json", ".json", write, Options,
        "For pages that show the machine their own way.", by_default=False,
    )  # fmt: skip
