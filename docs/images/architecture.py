"""Draws docs/images/architecture.svg: rooms on their floors, and the way of a request."""

from pathlib import Path

FLOORS = [
    ("service", "routes · resources · workers · storage · sweeps · client"),
    ("studies | machines", "many designs, given cams | spatial cams, linkages, trains"),
    ("pipeline", "spec → design, on one page"),
    ("optimise | certify | exporters", "driver and its roles | two judges | files"),
    ("design", "what is delivered"),
    ("spec", "what is asked"),
    ("catalogue", "laws, followers, limits, objectives, forces"),
    ("numerics", "splines, enclosures, solvers"),
]
WIDTH, LEFT, HIGH, GAP = 640, 20, 46, 10


def main() -> None:
    body, y = [], 20
    for name, says in FLOORS:
        parts, texts = name.split(" | "), says.split(" | ")
        wide = (WIDTH - GAP * (len(parts) - 1)) / len(parts)
        for k, part in enumerate(parts):
            x = LEFT + k * (wide + GAP)
            text = texts[k] if len(texts) == len(parts) else says
            body += [
                f'<rect x="{x:.0f}" y="{y}" width="{wide:.0f}" height="{HIGH}" rx="6"/>',
                f'<text class="name" x="{x + wide / 2:.0f}" y="{y + 19}">{part}</text>',
                f'<text x="{x + wide / 2:.0f}" y="{y + 36}">{text}</text>',
            ]
        y += HIGH + GAP
    style = (
        "rect{fill:#f4f6f8;stroke:#5b6b7b}"
        "text{font:11px sans-serif;fill:#33414f;text-anchor:middle}"
        ".name{font-weight:bold;font-size:14px}"
    )
    note = (
        "A room imports only rooms on floors below it; rooms side by side do not know each other."
    )
    body.append(f'<text x="{LEFT + WIDTH / 2:.0f}" y="{y + 8}">{note}</text>')
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH + 2 * LEFT} {y + 20}">'
        f"<style>{style}</style>{''.join(body)}</svg>\n"
    )
    Path(__file__).with_suffix(".svg").write_text(svg, encoding="utf-8")


if __name__ == "__main__":
    main()
