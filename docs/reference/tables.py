"""Tables as the pages of this folder have them: Markdown, printed."""


def number(value: float | None, digits: int = 4) -> str:
    """So many decimals, and no zero with a minus; nothing where there is no value."""
    return "" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"


def table(*rows: tuple[str, ...], first: str = "---") -> None:
    """The first row is the head; columns are numbers, to the right, but perhaps the first."""
    head, *body = rows
    lines = [head, (first, *("--:" for _ in head[1:])), *body]
    print("\n".join("| " + " | ".join(row) + " |" for row in lines) + "\n")
