"""A machine in motion as one SVG: CSS keyframes, no script; it stands still where that is wanted.

A roller turns by its mean speed and around it: the one repeats after a whole turn of the roller,
the other after one of the cam, so that it never jumps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from synthesis.exporters.animations.scene import DIAGRAMS, EDGE, MACHINE, TURN_S, Scene
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.machine import Moving
from synthesis.exporters.options import Theme

FRAMES = 240
HEADER, FOOTER = 16.0, 8.0
WIDTH = 2.0 * EDGE + MACHINE[0] + DIAGRAMS[0]
FULL = 360.0


def draw(scene: Scene, theme: Theme) -> bytes:
    """The scene as one SVG: the machine on the left, its diagrams on the right."""
    prefix = f"cw{scene.key[:8]}"
    height = HEADER + max(MACHINE[1], DIAGRAMS[1]) + FOOTER

    def tag(part: str) -> str:
        return f'class="{prefix}-{part}"'

    body = [
        *scene.heading,
        f'<g transform="translate({svg.num(EDGE)} {svg.num(HEADER)})">',
        *scene.machine(tag),
        "</g>",
        f'<g transform="translate({svg.num(EDGE + MACHINE[0])} {svg.num(HEADER)})">',
        *scene.diagrams(tag),
        "</g>",
        svg.text("tick", EDGE, height - 3.5, scene.footer),
    ]
    rules = scene.rules + "".join(_rules(prefix, scene))
    title = f"{scene.name or scene.key} in motion"
    return svg.document(WIDTH, height, 1.0, title, scene.described, body, theme=theme, rules=rules)


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
