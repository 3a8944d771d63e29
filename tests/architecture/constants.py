"""The numeric constants of the product, room by room: ``python -m tests.architecture.constants``.

Writes ``docs/constants.md``. A constant is a name in capitals in a module that stands for a number,
or for a tuple of numbers; its unit and reason stand behind it or below it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TARGET = ROOT / "docs" / "constants.md"
NAME = re.compile(r"_?[A-Z][A-Z0-9_]*")
HEAD = """# Numeric constants

The numbers of the product by room, with unit and reason. `make constants` writes this page out of
the modules, and a test holds it to them. A constant whose change changes nothing is removed.
"""


@dataclass(frozen=True)
class Constant:
    """Names that stand for numbers, their values as written, and the reason."""

    module: str
    names: tuple[str, ...]
    value: str
    reason: str

    @property
    def room(self) -> str:
        """The package of the core, or the service."""
        parts = self.module.split("/")
        return "service" if parts[0] == "service" else "/".join(parts[:2]).removesuffix(".py")


def constants() -> Iterator[Constant]:
    """All of them, module by module."""
    for package in ("service", "synthesis"):
        for path in sorted((ROOT / package).rglob("*.py")):
            yield from _of_module(path)


def _of_module(path: Path) -> Iterator[Constant]:
    source = path.read_text("utf-8")
    lines, body = source.splitlines(), ast.parse(source).body
    for statement, below in zip(body, [*body[1:], None], strict=True):
        if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
            continue
        targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
        names = [n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)]
        if not (all(map(NAME.fullmatch, names)) and _is_number(statement.value)):
            continue
        module = path.relative_to(ROOT).as_posix()
        value = ast.unparse(statement.value)
        value = value[1:-1] if isinstance(statement.value, ast.Tuple) else value
        yield Constant(module, tuple(names), value, _reason(statement, below, lines))


def _is_number(value: ast.expr) -> bool:
    """Whether an expression is made of numbers alone."""
    if isinstance(value, ast.Tuple | ast.List):
        return all(map(_is_number, value.elts))
    if isinstance(value, ast.BinOp):
        return _is_number(value.left) and _is_number(value.right)
    if isinstance(value, ast.UnaryOp):
        return _is_number(value.operand)
    number = isinstance(value, ast.Constant) and type(value.value) in (int, float)
    return number or ast.unparse(value) in ("pi", "math.pi", "np.pi")


def _reason(statement: ast.stmt, below: ast.stmt | None, lines: list[str]) -> str:
    """What stands behind the statement, as a string below it, or above its block of lines."""
    if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant):
        return " ".join(str(below.value.value).split())
    first, last = statement.lineno - 1, statement.end_lineno or statement.lineno
    behind = _comments(lines[first:last])
    if behind:
        return behind
    start = next(k for k in range(first, -1, -1) if not lines[k].strip())
    return _comments(line for line in lines[start:first] if line.startswith("# "))


def _comments(lines: Iterable[str]) -> str:
    words = (line.partition("#")[2].strip() for line in lines)
    return " ".join(word for word in words if word and not word.startswith(("fmt:", "--")))


def page() -> str:
    """The page of all constants."""
    parts = [HEAD]
    found = sorted(constants(), key=lambda one: (one.room, one.module))
    for room, members in groupby(found, key=lambda one: one.room):
        parts.append(
            f"## {room}\n\n| constant | value | unit, reason | module |\n|---|---|---|---|\n"
        )
        prefix = f"{room}/"
        for one in members:
            cells = (
                ", ".join(f"`{name}`" for name in one.names), f"`{one.value}`",
                one.reason.replace("|", "\\|"), one.module.removeprefix(prefix),
            )  # fmt: skip
            parts[-1] += f"| {' | '.join(cells)} |\n"
    return "\n".join(parts)


if __name__ == "__main__":
    TARGET.write_text(page(), "utf-8")
