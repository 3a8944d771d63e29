"""One style for all drawings: colours, lines and letters, for a screen, a dark screen and print.

No ids and no CSS variables, so that drawings can stand side by side in one page and plain viewers
show them as well as browsers do. Kinds of lines differ in width and pattern too, never in colour
alone. Lengths are multiples of a sheet's unit u.
"""

from __future__ import annotations

from typing import get_args

from synthesis.exporters.options import Theme

THEMES: tuple[Theme, ...] = get_args(Theme)
"""auto: light, and dark on a screen that asks for it; print: black on white, for any printer."""

FONT = "'Helvetica Neue',Helvetica,Arial,'Liberation Sans','DejaVu Sans',sans-serif"
TITLE, LABEL, TICK = 4.4, 2.9, 2.6  # heights of letters, in u
SIZES = {"title": TITLE, "label": LABEL, "quiet": LABEL, "tick": TICK, "alarm": LABEL}
WORST, DARKEST = "#b3261e", "#ff8f85"  # of what is wrong

# class: (light, dark, print)
FILLS = {
    "ground": ("#ffffff", "#15191e", "#ffffff"),
    "title": ("#14181d", "#f0f3f6", "#000000"),
    "label": ("#14181d", "#f0f3f6", "#000000"),
    "quiet": ("#565e68", "#a4adb8", "#000000"),
    "tick": ("#565e68", "#a4adb8", "#000000"),
    "alarm": (WORST, DARKEST, "#000000"),
    "body": ("#0b57a4", "#82bbf5", "#000000"),
    "metal": ("#ffffff", "#15191e", "#ffffff"),
    "rest": ("#f1f3f5", "#1d2228", "#f0f0f0"),
    "solid": ("#14181d", "#f0f3f6", "#000000"),
    "start": ("#0b57a4", "#82bbf5", "#000000"),
    "several": ("#cfe0f0", "#24405c", "#cccccc"),
    "undercut": ("#f7e3e1", "#3a2222", "#e4e4e4"),
    "mark": ("#b34700", "#f5a65b", "#000000"),
    "glass": ("#ffffff", "#15191e", "#ffffff"),
    "item": ("#8a939d", "#78828d", "#999999"),
}
# class: (light, dark, print, width, dashes)
STROKES = {
    "outline": ("#14181d", "#f0f3f6", "#000000", 0.5, ""),
    "curve": ("#0b57a4", "#82bbf5", "#000000", 0.5, ""),
    "pitch": ("#0b57a4", "#82bbf5", "#000000", 0.3, ""),
    "circle": ("#565e68", "#a4adb8", "#000000", 0.25, "1.6 1"),
    "prime": ("#565e68", "#a4adb8", "#000000", 0.25, "4 1.2"),
    "axis": ("#565e68", "#a4adb8", "#000000", 0.2, ""),
    "centre": ("#8a939d", "#78828d", "#555555", 0.15, "5 1 1 1"),
    "grid": ("#dde2e7", "#2b323a", "#c4c4c4", 0.15, ""),
    "border": ("#8a939d", "#78828d", "#555555", 0.2, ""),
    "jump": ("#0b57a4", "#82bbf5", "#000000", 0.2, "0.6 0.6"),
    "phase": ("#0b57a4", "#82bbf5", "#000000", 0.3, "1.6 0.8"),
    "limit": (WORST, DARKEST, "#000000", 0.3, "2.4 1.2"),
    "broken": (WORST, DARKEST, "#000000", 1.1, ""),
    "hatch": (WORST, DARKEST, "#000000", 0.2, ""),
    "normal": ("#b34700", "#f5a65b", "#000000", 0.35, "3 0.8"),
    "front": ("#0b57a4", "#82bbf5", "#000000", 0.35, "2 1"),
    "halo": ("#ffffff", "#15191e", "#ffffff", 1.2, ""),
    "inner": ("#ebf2f8", "#202831", "#ebebeb", 1.2, ""),
}
COLUMN = {"auto": 0, "light": 0, "dark": 1, "print": 2}


def style(u: float, theme: Theme = "auto") -> str:
    """The style sheet for a sheet whose unit is ``u`` mm; ``auto`` is dark only on a screen."""
    sheet = [f".camwright text{{font-family:{FONT};font-variant-numeric:tabular-nums}}"]
    sheet += [f".camwright .{name}{{font-size:{num(k * u)}px}}" for name, k in SIZES.items()]
    sheet.append(".camwright .title{font-weight:600}")
    sheet += _colours(COLUMN[theme])
    sheet += lines(u)
    sheet.append(".camwright path{stroke-linejoin:round;stroke-linecap:round}")
    sheet.append(
        ".camwright .line{fill:none}.camwright .body{fill-opacity:.08}"
        ".camwright .glass{fill-opacity:.55}"
    )
    sheet.append(".camwright text{paint-order:stroke;stroke-linejoin:round}")
    if theme == "auto":
        dark = "".join(_colours(COLUMN["dark"]))
        sheet.append(f"@media screen and (prefers-color-scheme:dark){{{dark}}}")
    return "".join(sheet)


def lines(u: float, within: str = ".camwright") -> list[str]:
    """Rules for widths and dashes of all kinds of lines, of a unit of ``u`` mm."""
    rules = []
    for name, (*_, width, pattern) in STROKES.items():
        dashes = " ".join(num(float(k) * u) for k in pattern.split())
        dashed = f";stroke-dasharray:{dashes}" if dashes else ""
        rules.append(f"{within} .{name}{{stroke-width:{num(width * u)}{dashed}}}")
    return rules


def _colours(column: int) -> list[str]:
    rules = [f".camwright .{name}{{fill:{fill[column]}}}" for name, fill in FILLS.items()]
    strokes = ((name, stroke[:3][column]) for name, stroke in STROKES.items())
    return rules + [f".camwright .{name}{{stroke:{colour}}}" for name, colour in strokes]


def num(value: float, decimals: int = 4) -> str:
    """A coordinate without trailing zeros."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
