"""Questions read, answered by a service or here, and the answers printed or written.

A question is a file, a worked example by its name, or standard input: there each answer is a line
of JSON, in the order of the questions, and so is what says why there is none. `stream` reads the
questions of a pipe, `tables` has what is printed for people. Begin with `run`.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import urlsplit

import typer
from pydantic import BaseModel, ValidationError

from service.client import Client, Refused, Unreachable
from service.client.exchange import sentences
from service.commands.display import Table, in_inches
from service.commands.stream import documents
from service.commands.terminal import STREAM, Units, complain, name_files, say, stop, write
from service.contract.examples import example_path
from service.settings import settings_from
from service.wire.errors import ProblemType, ServiceError
from service.wire.problem import problem_document, problem_of
from service.wire.validation import Model, parse_json, validate
from synthesis.design.design import Design
from synthesis.errors import CamwrightError, TimeBudgetExceeded
from synthesis.exporters.exporter import compact_json

MIN_WIDTH = 120  # characters that the widest table needs
CONTINUES = "The service continues; the same command asks for the answer again."
NEGATIVE, REFUSED = 3, 2  # exit codes: answered, but with "no"; not answered


@dataclass(frozen=True)
class QuestionKind:
    """A kind of question: how one is read and answered.

    Attributes:
        model: of the question. answer: a question's answer; its errors are those of the core, of
            the service and of the client.
    """

    model: type[BaseModel]
    answer: Callable[[Any], Any]


@dataclass(frozen=True)
class Shown:
    """What a command makes of an answer.

    Attributes:
        describe: the lines and tables that are printed, of the answer and the seconds it took.
        files: by name, written where there is a folder. listed: names printed instead of theirs.
        is_negative: whether the answer is a "no", such as that no cam fits.
        conclusion: a last line.
    """

    describe: Callable[[Any, float], Iterable[str | Table]]
    files: Callable[[Any], Mapping[str, bytes]] = lambda _: {}
    listed: Callable[[Mapping[str, bytes]], Iterable[str]] = lambda files: files
    is_negative: Callable[[Any], bool] = lambda _: False
    conclusion: Callable[[Any], str] = lambda _: ""


def run(
    kind: str | QuestionKind,
    question: Path,
    shown: Shown,
    *,
    url: str | None = None,
    folder: Path | None = None,
    as_json: bool = False,
    units: Units = Units.mm,
    more: Mapping[str, Any] | None = None,
) -> None:
    """Answer the question, or those of standard input; exits as `camwright --help` says.

    Args:
        kind: a collection below /v1/, or what a command computes itself.
        question: a file, the name of a worked example, or ``STREAM``.
        shown: what is printed and written. folder: for files; None: none are written.
        url: of the service that answers; None: computed here.
        as_json: print the answer as the service sends it. more: fields of the question.
    """
    with ExitStack() as stack:
        if question == STREAM:
            asked = kind if isinstance(kind, QuestionKind) else collection_of(kind, url, stack)
            try:
                code = _answer_stream(asked, shown, url, folder, more)
            except KeyboardInterrupt:
                code = 130  # what is answered is printed
            raise typer.Exit(code)
        stopped = CONTINUES if url else "Nothing was written."
        stack.enter_context(report_errors(question, url, stopped))
        asked = kind if isinstance(kind, QuestionKind) else collection_of(kind, url, stack)
        known = read_spec(question, asked.model, more)
        started = time.perf_counter()
        with _spinner(url):
            answer = _or_best(asked, known)
        seconds = time.perf_counter() - started
    # Files come first: who reads the lines may stop (`| head`), and the rest is never printed.
    files = {} if folder is None else shown.files(answer)
    if folder is not None:
        write(files, folder)
    print_answer(answer, shown.describe(answer, seconds), as_json, units)
    if folder is not None and files and not as_json:
        name_files(list(shown.listed(files)), folder)
    if conclusion := shown.conclusion(answer):
        say(conclusion)
    if shown.is_negative(answer):
        raise typer.Exit(NEGATIVE)


def collection_of(name: str, url: str | None, stack: ExitStack) -> QuestionKind:
    """The questions of a collection, answered by a service or, without a URL, by this process."""
    # Imported here: it takes as long as all else that a command imports, and not all need it.
    from service.resources.records import RESOURCES

    resource = RESOURCES[f"/v1/{name}"]
    if url is None:
        return QuestionKind(resource.spec, lambda question: _compute(resource, question))
    client = stack.enter_context(Client(valid_address(url)))

    def ask(question: BaseModel) -> BaseModel:
        try:
            document = client.answer(resource.path, question)
        except Refused as error:
            if error.best is not None:
                raise TimeEnded(str(error), _read_answer(resource, error.best, url)) from error
            raise
        return _read_answer(resource, document, url)

    return QuestionKind(resource.spec, ask)


class TimeEnded(TimeBudgetExceeded):
    """A service said that time ended, in these words, with the best answer so far."""

    def __init__(self, words: str, best: BaseModel) -> None:
        super().__init__(0.0, best)
        self.args = (words,)


def _read_answer(resource: Any, document: Any, url: str) -> BaseModel:
    try:
        answer: BaseModel = resource.answer.model_validate_json(json.dumps(document))
    except ValidationError as error:
        first = error.errors()[0]
        where = "/".join(str(part) for part in first["loc"])
        stop(
            f"The answer of {url} is not in the form that this command knows ({where}: "
            f"{first['msg']}). Compare GET /v1/version with camwright --version."
        )
    return answer


def _compute(resource: Any, question: Any) -> BaseModel:
    """The answer to a question, without links: no service keeps it."""
    from service.workers.tasks import solve_design

    task = resource.task or solve_design
    budget_s = settings_from().budget_s(getattr(question, "time_budget_s", None))
    body = task(question.model_dump_json().encode(), budget_s).body
    result: BaseModel = resource.answer.model_validate_json(body)
    return result.model_copy(update={"links": {}}) if hasattr(result, "links") else result


def _or_best(asked: QuestionKind, question: Any) -> Any:
    """The answer; where time ends, the best so far."""
    try:
        return asked.answer(question)
    except TimeBudgetExceeded as error:
        if error.best is None:
            raise
        complain(str(error))
        return error.best


def _answer_stream(
    asked: QuestionKind,
    shown: Shown,
    url: str | None,
    folder: Path | None,
    more: Mapping[str, Any] | None,
) -> int:
    """Answer each question of standard input with a line; the exit code, of the worst."""
    worst = 0
    for number, body in enumerate(documents(sys.stdin.buffer), start=1):
        code, files = 0, dict[str, bytes]()
        try:
            document = parse_json(body)
            if _is_problem(document):  # of the command before in the pipe: it is handed on
                worst = REFUSED
                typer.echo(compact_json(document).decode())
                continue
            answer = asked.answer(_read_body(body, asked.model, more))
        except (ServiceError, CamwrightError, Refused, Unreachable) as error:
            line = compact_json({**_problem(error, url), "instance": f"#{number}"}).decode()
            code = 0 if getattr(error, "best", None) is not None else REFUSED
        else:
            line = compact_json(_plain(answer)).decode()
            code = NEGATIVE if shown.is_negative(answer) else 0
            files = dict(shown.files(answer)) if folder is not None else {}
        if folder is not None:
            write(files, folder / str(number))
        typer.echo(line)
        # Not answered weighs more than "no", and "no" more than an answer.
        worst = code if code == REFUSED or worst == 0 else worst
    return worst


def _is_problem(document: Any) -> bool:
    return isinstance(document, dict) and str(document.get("type")).startswith("/problems/")


def _plain(answer: Any) -> dict[str, Any]:
    """An answer as a JSON document."""
    plain: dict[str, Any] = answer if isinstance(answer, dict) else answer.model_dump(mode="json")
    return plain


def _problem(error: Exception, url: str | None) -> dict[str, Any]:
    """A problem document, as a service sends it."""
    if isinstance(error, Refused):
        return error.problem
    if isinstance(error, Unreachable):
        detail = f"No answer from {url} ({error}). Is it running?"
        return problem_document(ProblemType.ENGINE_UNREACHABLE, detail)
    return problem_of(error)


def read_spec(path: Path, model: type[Model], more: Mapping[str, Any] | None = None) -> Model:
    """The spec in a file or of an example, with ``more`` fields; a line for each error."""
    try:
        return _read_body(_bytes_of(path), model, more)
    except ServiceError as error:
        _stop_for(path, error)


def design_of(path: Path) -> Design:
    """The design in a file, or that of the spec in the file, computed now."""
    body = _bytes_of(path)
    try:
        document = parse_json(body)
        if isinstance(document, dict) and "certificate" in document:
            return validate(body, Design)
        with ExitStack() as stack:
            asked = collection_of("designs", None, stack)
            design: Design = _or_best(asked, _read_body(body, asked.model, None))
    except ServiceError as error:
        _stop_for(path, error)
    return design


def _bytes_of(path: Path) -> bytes:
    if path == STREAM:
        return sys.stdin.buffer.read()
    try:
        return path.read_bytes()
    except OSError as error:
        example = example_path(path.name) if path.name == str(path) else None
        if example is None:
            stop(
                f"{path} cannot be read: {error.strerror}. It is no worked example either: "
                "camwright examples lists them."
            )
        return example.read_bytes()


def _read_body(body: bytes, model: type[Model], more: Mapping[str, Any] | None) -> Model:
    """A spec; a worked example has it under ``value``."""
    document = parse_json(body)
    if isinstance(document, dict) and "value" in document:
        document = document["value"]
        body = json.dumps(document).encode()
    if isinstance(document, dict):
        _check_kind(document, model)
    if more and isinstance(document, dict):
        body = json.dumps({**document, **more}).encode()
    return validate(body, model)


def _check_kind(document: Mapping[str, Any], model: type[BaseModel]) -> None:
    """Refuse a question in place of a design, and the reverse, by one sentence of it."""
    if model is Design and "certificate" not in document and "program" in document:
        raise ProblemType.INVALID_REQUEST(
            "This is a question, not a design. Design it first: camwright design"
        )
    if model is not Design and "certificate" in document and "spec" in document:
        raise ProblemType.INVALID_REQUEST('This is a design already. Its question is under "spec".')


def _stop_for(path: Path, error: ServiceError) -> NoReturn:
    if not error.violations:
        stop(f"{path}: {error}")
    for violation in error.violations:
        where = violation["pointer"] or "the document"
        value = json.dumps(violation["value"], ensure_ascii=False)
        complain(f"{path}: {where} = {value}: {sentences(violation)}")
    raise typer.Exit(2)


@contextmanager
def report_errors(path: Path, url: str | None, stopped: str) -> Iterator[None]:
    """Print the errors of the core and of a client, each wrong field in a line, and exit.

    Args:
        path: file of the question. url: of the service; None: one started by this command.
        stopped: what happens to the question after Ctrl-C.
    """
    try:
        yield
    except CamwrightError as error:
        stop(str(error))
    except ServiceError as error:
        _stop_for(path, error)
    except Refused as error:
        for wrong in error.errors:
            where = wrong.get("pointer") or wrong.get("parameter") or "the document"
            complain(f"{path}: {where}: {sentences(wrong)}")
        stop(str(error).partition("\n")[0])
    except Unreachable as error:
        stop(f"No answer from {url or 'the service started for this'} ({error}). Is it running?")
    except KeyboardInterrupt:
        complain(f"Stopped waiting. {stopped}" if url else f"Stopped. {stopped}")
        raise typer.Exit(130) from None


def valid_address(url: str) -> str:
    """The address of a service; exits where it is not one."""
    parts = urlsplit(url)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        stop(
            f"{url} is not the address of a service, such as http://127.0.0.1:8000. See --url or "
            "CAMWRIGHT_URL."
        )
    return url


@contextmanager
def _spinner(url: str | None) -> Iterator[None]:
    """A spinner on the terminal with the elapsed time, where a service is waited for."""
    if url is None or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        progress.add_task(f"waiting for {url}", total=None)
        yield


def print_answer(
    answer: Any, parts: Iterable[str | Table], as_json: bool = False, units: Units = Units.mm
) -> None:
    """Print an answer in lines and tables, or as the service sends it, for other programs."""
    if as_json:
        typer.echo(answer.model_dump_json(indent=1))
        return
    from rich.console import Console

    wide = Console(highlight=False, markup=False)
    wide.width = max(wide.width, MIN_WIDTH)
    for given in parts:
        part = in_inches(given) if units is Units.inch else given
        if isinstance(part, str):
            say(part)
        else:
            wide.print(part.drawn())


def files_of(name: str, answer: BaseModel, formats: Iterable[Any] = ()) -> dict[str, bytes]:
    """An answer as the file ``name``, and those of its formats that are written by default."""
    files = {each.name: each.write(answer, each.options()) for each in formats if each.by_default}
    return {name: answer.model_dump_json(indent=1).encode(), **files}
