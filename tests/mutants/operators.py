"""Faults to plant in a module: edits of its source, each made by one operator.

An edit replaces the text of one node of the syntax tree and leaves the rest as it stands. Operators
are aimed at what a claim rests on: directions of rounding, allowances for it, signs of terms, rows
of a list, guards; in the store also at conditions of statements and at transactions.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

Found = Iterator[tuple[str, ast.AST, str]]  # operator, the node that is replaced, and by what

SWAPPED = {
    "rounding": {"floor": "ceil", "lower": "upper", "low": "high", "lo": "hi"},
    "extreme": {
        "min": "max", "minimum": "maximum", "fmin": "fmax", "argmin": "argmax", "any": "all",
        "nanmin": "nanmax",
    },
}  # fmt: skip
OPERATOR_OF = {
    word: (operator, other)
    for operator, pairs in SWAPPED.items()
    for one, two in pairs.items()
    for word, other in ((one, two), (two, one))
}
TURNED = {ast.Lt: ">", ast.LtE: ">=", ast.Gt: "<", ast.GtE: "<="}
# Names of allowances. Widths and budgets of searches decide how long they take, and no claim.
ALLOWANCES = re.compile(r"ROUNDING|TOLERANCE|DEPTH|CUSP|CLEARANCE|LOOSENING|OUTSIDE|AT_JUNCTION")
ERRORS = re.compile(r"_truncation\b|\b(rem|remainder|error|errors|rounding|spread|slack|blur)\b")
STEPS = re.compile(r"\bstep =")
LEAVES = (ast.Return, ast.Raise, ast.Continue, ast.Break)
ADDS_ROWS = {"append", "extend", "add", "update", "setdefault", "merge", "insert"}
CONDITIONS = {"where", "filter_by", "values", "or_", "and_"}
ENDS = {"commit", "rollback", "flush", "execute"}


@dataclass(frozen=True)
class Fault:
    """A planted fault: ``before`` at ``start`` (in bytes) of a file is replaced by ``after``.

    ``scope``: qualified name of the function or class around it; ``lines``: those of the node, and
    ``statement``: those of the statement around it; ``number``: of those that read the same.
    """

    file: str
    scope: str
    operator: str
    start: int
    before: str
    after: str
    lines: range
    statement: range
    number: int = 0

    @property
    def key(self) -> str:
        """The fault's name, which stays when lines move."""
        text = [re.sub(r"\s+", " ", each) for each in (self.before, self.after)]
        number = f" ({self.number + 1})" if self.number else ""
        return f"{self.file} {self.scope or '-'} {self.operator}: {text[0]} → {text[1]}{number}"

    def plant(self, source: str) -> str:
        """The source with the fault."""
        text, size = source.encode(), len(self.before.encode())
        return (text[: self.start] + self.after.encode() + text[self.start + size :]).decode()

    @property
    def place(self) -> str:
        return f"{self.file}:{self.lines.start}"

    def changes(self, source: str) -> bool:
        """Whether the source with the fault is another program, and one that compiles."""
        try:
            planted = ast.parse(self.plant(source))
        except SyntaxError:
            return False
        return ast.dump(planted) != ast.dump(ast.parse(source))


def faults(file: str, source: str, *, store: bool = False) -> list[Fault]:
    """All faults that the operators plant in a module; ``store``: also those of statements."""
    found, numbers = list[Fault](), dict[str, int]()
    module = Module(source)
    for operator, node, after in module.edits(store):
        start, before = module.span(node)
        statement = module.statement_of(node)
        fault = Fault(
            file, module.scope_of(node), operator, start, before, after, _lines(node),
            _lines(statement),
        )  # fmt: skip
        number = numbers[fault.key] = numbers.get(fault.key, -1) + 1
        found.append(Fault(**{**vars(fault), "number": number}))
    return found


def _lines(node: ast.AST) -> range:
    return range(node.lineno, node.end_lineno + 1)  # type: ignore[attr-defined]


class Module:
    """A module's syntax tree with the text of each node."""

    def __init__(self, source: str) -> None:
        self.source, self.tree = source, ast.parse(source)
        self._rows = source.encode().splitlines(keepends=True)
        self._parent = {
            child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)
        }

    @cached_property
    def line_names(self) -> list[str]:
        """Every line by the function around it and its text, which stay when lines move."""
        scopes = dict[int, str]()
        for node in ast.walk(self.tree):  # outer ones first
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                scopes |= dict.fromkeys(_lines(node), self.scope_of(node))
        rows = self.source.splitlines()
        return ["", *(f"{scopes.get(k, '')}: {row.strip()}" for k, row in enumerate(rows, 1))]

    @cached_property
    def _offsets(self) -> list[int]:
        offsets = [0]
        for row in self._rows:
            offsets.append(offsets[-1] + len(row))
        return offsets

    def span(self, node: ast.AST) -> tuple[int, str]:
        """Where a node begins, in bytes, and its text."""
        start = self._offsets[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        end = self._offsets[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
        return start, self.source.encode()[start:end].decode()

    def text(self, node: ast.AST) -> str:
        return self.span(node)[1]

    def _around(self, node: ast.AST) -> Iterator[ast.AST]:
        while (node := self._parent.get(node)) is not None:  # type: ignore[assignment]
            yield node

    def statement_of(self, node: ast.AST) -> ast.AST:
        return next((n for n in (node, *self._around(node)) if isinstance(n, ast.stmt)), self.tree)

    def scope_of(self, node: ast.AST) -> str:
        """Qualified name of the innermost function or class around a node."""
        kinds = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
        names = [n.name for n in (node, *self._around(node)) if isinstance(n, kinds)]
        return ".".join(reversed(names))

    def edits(self, store: bool) -> Found:
        """What every operator makes of the bodies of functions and methods."""
        operators = [swaps, allowances, signs, factors, rows, guards]
        for function in ast.walk(self.tree):
            if not isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
                continue
            for statement in function.body:
                for node in _walk(statement):
                    if isinstance(node, ast.expr | ast.Expr) and "sleep(" in self.text(
                        self.statement_of(node)
                    ):
                        continue  # how long it waits
                    for operator in [*operators, conditions] if store else operators:
                        yield from operator(self, node)
            yield from answers(function)


def _walk(node: ast.AST) -> Iterator[ast.AST]:
    """A node and what it holds, without functions in it (walked by themselves) and texts."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.JoinedStr):
        return
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.arg) and not _is_annotation(node, child):
            yield from _walk(child)


def _is_annotation(node: ast.AST, child: ast.AST) -> bool:
    return isinstance(node, ast.AnnAssign) and child is node.annotation


def swaps(module: Module, node: ast.AST) -> Found:
    """Rounding to the other side; the other end; the least for the largest, all for any."""
    word, called = None, isinstance(module._parent.get(node), ast.Call)
    if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
        word = node.attr
    elif isinstance(node, ast.Name) and called and node is module._parent[node].func:  # type: ignore[attr-defined]
        word = node.id
    if word in OPERATOR_OF:
        operator, other = OPERATOR_OF[word]
        yield operator, node, module.text(node)[: -len(word)] + other
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in TURNED:
        left, right = module.text(node.left), module.text(node.comparators[0])
        yield "comparison", node, f"{left} {TURNED[type(node.ops[0])]} {right}"


def allowances(module: Module, node: ast.AST) -> Found:
    """An allowance that is none, and one that is a thousand times too large; no remainder."""
    if isinstance(node, ast.Name) and ALLOWANCES.search(node.id):
        yield "allowance", node, "0.0"
        yield "allowance", node, f"(1e3 * {module.text(node)})"
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        right = module.text(node.right)
        if ERRORS.search(right):
            yield "allowance", node, module.text(node.left)


def signs(module: Module, node: ast.AST) -> Found:
    """The other sign of a term or a value."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        left, right = module.text(node.left), module.text(node.right)
        no_number = ast.List | ast.Tuple | ast.JoinedStr | ast.ListComp
        if not any(isinstance(each, no_number) for each in (node.left, node.right)):
            turned = "-" if isinstance(node.op, ast.Add) else "+"
            yield "sign", node, f"{left} {turned} {right}"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "sign", node, module.text(node.operand)


def factors(module: Module, node: ast.AST) -> Found:
    """A factor that is off by one per cent; an interval or a knot too few, at either end."""
    # one per cent of an error bound, or of a search's step, is not seen, nor need it be
    statement = f"{module.scope_of(node)} {module.text(module.statement_of(node))}"
    is_loose = any(words.search(statement) for words in (ALLOWANCES, ERRORS, STEPS))
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div) and not is_loose:
        for number in (node.left, node.right):
            if isinstance(number, ast.Constant) and isinstance(number.value, float):
                yield "factor", number, f"({module.text(number)} * 0.99)"
    if isinstance(node, ast.Slice):
        for end, step in ((node.lower, 1), (node.upper, -1)):
            if end is not None:
                yield "interval", end, f"{module.text(end)} {'+-'[step < 0]} 1"
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range":
        last = node.args[:2][-1]
        yield "interval", last, f"{module.text(last)} - 1"


def rows(module: Module, node: ast.AST) -> Found:
    """One row less: of a list, of what is iterated over, of what is collected or yielded."""
    iterated = isinstance(node, ast.Tuple) and any(
        isinstance(parent, ast.For | ast.comprehension) and parent.iter is node
        for parent in (module._parent.get(node),)
    )
    if (isinstance(node, ast.List) or iterated) and isinstance(node.ctx, ast.Load):  # type: ignore[attr-defined]
        elements = node.elts  # type: ignore[attr-defined]
        for dropped in elements if len(elements) > 1 else ():
            kept = ", ".join(module.text(each) for each in elements if each is not dropped)
            yield "row", node, f"[{kept}]"
    if isinstance(node, ast.Expr):
        value = node.value.value if isinstance(node.value, ast.Await) else node.value
        if isinstance(value, ast.Yield | ast.YieldFrom):
            yield "row", node, "yield from ()"
        called = value.func if isinstance(value, ast.Call) else None
        if isinstance(called, ast.Attribute) and called.attr in ADDS_ROWS:
            yield "row", node, "pass"
    if isinstance(node, ast.AugAssign):
        yield "row", node, "pass"
    if isinstance(node, ast.comprehension) and node.ifs:
        for condition in node.ifs:
            yield "guard", condition, "True"


def guards(module: Module, node: ast.AST) -> Found:
    """A guard that never acts, a condition less, an error that is not raised."""
    if isinstance(node, ast.If) and isinstance(node.body[-1], LEAVES) and not node.orelse:
        yield "guard", node.test, "False"
        yield "early", node.test, "True"
    if isinstance(node, ast.BoolOp):
        for dropped in node.values:
            kept = [module.text(each) for each in node.values if each is not dropped]
            word = " and " if isinstance(node.op, ast.And) else " or "
            yield "guard", node, f"({word.join(kept)})"
    if isinstance(node, ast.Raise):
        yield "guard", node, "pass"


def answers(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Found:
    """A check that is always passed, or never."""
    if isinstance(function.returns, ast.Name) and function.returns.id == "bool":
        for statement in function.body:
            for node in _walk(statement):
                if isinstance(node, ast.Return) and node.value is not None:
                    yield "answer", node.value, "True"
                    yield "answer", node.value, "False"


def conditions(module: Module, node: ast.AST) -> Found:
    """A statement without one of its conditions or values; no lock, no transaction, no write."""
    if isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else module.text(node.func)
        given = [*node.args, *node.keywords]
        if name in CONDITIONS:
            for dropped in given:
                kept = ", ".join(module.text(each) for each in given if each is not dropped)
                yield "condition", node, f"{module.text(node.func)}({kept})"
        if name in ("with_for_update", "order_by", "limit"):
            yield "condition", node, module.text(node.func.value)  # type: ignore[attr-defined]
        if name == "begin":
            yield "transaction", node, f"{module.text(node.func.value)}()"  # type: ignore[attr-defined]
        for keyword in node.keywords:
            if keyword.arg == "with_for_update":
                yield "transaction", keyword.value, "False"
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Await):
        yield "transaction", node, "pass"
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        called = node.value.func
        if isinstance(called, ast.Attribute) and called.attr in ENDS:
            yield "transaction", node, "pass"
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
        yield "transaction", node, "pass"
