"""A machine in motion as one HTML page: played, stopped, stepped and read, without any network."""

from __future__ import annotations

import json

from synthesis.exporters.animations.scene import DIAGRAMS, MACHINE, Scene
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing import html
from synthesis.exporters.drawing.theme import style
from synthesis.exporters.options import Theme

FRAMES = 720
SHOWN_RPM = 8  # speed on the screen at first

CONTROLS = f"""<div class="controls" role="group" aria-label="Controls">
<button type="button" id="play">Pause</button>
<button type="button" id="back" aria-label="back by 1 degree">&#8722;1&#176;</button>
<button type="button" id="forward" aria-label="on by 1 degree">+1&#176;</button>
<label class="angle">Cam angle
<input type="range" id="angle" min="0" max="360" step="1" value="0"></label>
<label>Speed <input type="range" id="speed" min="1" max="61" step="1" value="{SHOWN_RPM}">
<span><output id="shown">{SHOWN_RPM}</output> turns a minute</span></label>
</div>"""
KEYS = """<p class="keys"><kbd>Space</kbd> plays and stops, <kbd>&#8592;</kbd> <kbd>&#8594;</kbd>
step by 1&#176;, with <kbd>Shift</kbd> by 10&#176;, <kbd>Home</kbd> goes to 0&#176;, <kbd>+</kbd>
<kbd>&#8722;</kbd> change the speed.</p>"""


def page(scene: Scene, theme: Theme) -> bytes:
    """The scene as a page with controls and numbers."""
    name = scene.name or scene.shaft.partition(" ")[0]
    data = {"parts": [part.data(scene.decimals) for part in scene.moving],
            "readings": scene.readings}  # fmt: skip
    body = "\n".join(
        [
            f"<h1>{html.plain(name)}</h1>\n<p>{html.plain(scene.about)}</p>",
            "<main>",
            _inline(scene.titles[0], MACHINE, scene.machine(tag)),
            _inline(scene.titles[1], DIAGRAMS, scene.diagrams(tag)),
            "</main>",
            CONTROLS.replace("Cam angle", scene.shaft),
            _readings(scene),
            KEYS,
            f'<script type="application/json" id="frames">{_json(data)}</script>',
        ]
    )
    sheet = style(1.0, theme) + scene.rules + html.asset("animation.css")
    return html.page(f"{name} in motion", sheet, body, theme, html.asset("animation.js"))


def tag(part: str) -> str:
    """The attribute that names a part."""
    return f'data-part="{part}"'


def _inline(title: str, size: tuple[float, float], body: list[str]) -> str:
    head = f'<svg class="camwright" role="img" viewBox="0 0 {size[0]:g} {size[1]:g}">'
    return "\n".join([head, f"<title>{title}</title>", *body, "</svg>"])


def _readings(scene: Scene) -> str:
    """Places of the numbers that follow the motion."""
    rows = [(scene.shaft, "theta", "°")]
    rows += [(r["title"], r["name"], r["unit"]) for r in scene.readings]
    text = [
        f'<div><dt>{title}</dt><dd><output id="{name}">&#8211;</output> {svg.unit(unit)}</dd></div>'
        for title, name, unit in rows
    ]
    return "<dl>" + "".join(text) + "</dl>"


def _json(data: object) -> str:
    """JSON that no page takes for its own elements."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False, ensure_ascii=True)
    return text.replace("<", "\\u003c")
