"""A kept resource as one record: question, task, answer, lists and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache, partial
from operator import attrgetter
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, create_model

from service.storage.store import Lookup
from service.storage.tables import AnswerRow, in_utc
from service.wire.errors import ProblemType
from service.workers.tasks import Task, links_to
from synthesis.design.design import Status
from synthesis.exporters import FileContent, form
from synthesis.exporters.exporter import FileFormat

StatusOrNone = Annotated[Status | None, Field(description="What came out; null until it is done.")]


class Accepted(BaseModel):
    """What is waiting or being worked on."""

    id: str = Field(description="The id that the answer will have.")
    name: str = Field(description="As in the spec.")
    state: Literal["accepted", "done", "failed"] = Field(
        description="`accepted` until it is done or failed."
    )
    created: datetime = Field(description="When it was accepted, UTC.")
    links: dict[str, str] = Field(description="Where to ask again.")


@cache
def page_of(summary: type[Accepted]) -> Any:
    """The model of a list with such lines, named as they are."""
    lines = (summary.__doc__ or "").replace("One line", "Lines").rstrip(".")
    name = summary.__name__.replace("Summary", "Page")
    following = Field(description="`cursor` of the next page; null at the end.")
    fields: dict[str, Any] = {
        "items": (list[summary], Field(description="The newest first.")),  # type: ignore[valid-type]
        "next": (str | None, following),
    }
    return create_model(name, __doc__=f"{lines}, the newest first.", **fields)


@dataclass(frozen=True)
class ResourceFile:
    """A file that is made of an answer.

    Attributes:
        path: the last part of its address. operation: name in the contract, without ``get_``.
        title, purpose: for people. media_type: with its parameters.
        query: the options as query parameters; options_of: those as ``make`` takes them.
        make: an answer's body and options to the file.
        in_worker: whether a worker makes it, because that takes long or much memory.
        download_name: what the name of a saved file ends in.
        made_by: what decides on its bytes besides the answer and the options.
    """

    path: str
    operation: str
    title: str
    media_type: str
    query: type[BaseModel]
    options_of: Callable[[Any], Any]
    make: Callable[[bytes, Any], FileContent]
    purpose: str
    in_worker: bool
    download_name: str
    made_by: str = ""


def file_of(
    write: Callable[[FileFormat[Any, Any], bytes, Any], FileContent],
    exporter: FileFormat[Any, Any],
    path: str,
    prefix: str = "",
    **more: Any,
) -> ResourceFile:
    """A file in a format of the core.

    Args:
        write: format, an answer's body and options to the file.
        prefix: of the operation's name. more: fields of ``ResourceFile`` that differ.
    """
    fields: dict[str, Any] = {
        "path": path,
        "operation": prefix + path.replace(".", "_"),
        "title": exporter.title,
        "purpose": exporter.purpose,
        "media_type": exporter.media_type,
        "query": form(exporter.options),
        "options_of": lambda query: exporter.options(**dict(query)),
        "in_worker": exporter.in_worker,
        "download_name": path,
        "make": partial(write, exporter),
    }
    return ResourceFile(**(fields | more))


@dataclass(frozen=True, eq=False)
class Resource:
    """A kind of question whose answers are kept.

    Attributes:
        path: of the collection, and the kind of its answers in the store.
        tag: section of the documentation, and file_tag: of its files' ("": the same).
        noun: what one is called. id_name: what paths call the id of one.
        spec: the question. answer: what it leads to. summary: a line of the list.
        id_of: question to id.
        task: what a worker does; None: what the engine was made for, which is to solve designs.
        unknown: the problem of an id that does not exist.
        title, text: what the contract says of POST, and answer_text: of GET.
        status: type of the filter of lists; None: there is none.
        budget_of: question to the time that it asks for [s]; None: what the server gives.
        elsewhere: finds answers that are kept as part of something else; None: there are none.
        files: what its answers can be had as.
        marks_broken_limits: whether the files of a cam that breaks its limits are named so.
        own_delete: whether its routes have a DELETE of their own.
    """

    path: str
    tag: str
    noun: str
    id_name: str
    spec: type[Any]
    answer: type[BaseModel]
    summary: type[Accepted]
    id_of: Callable[[Any], str]
    task: Task | None
    unknown: ProblemType
    title: str
    text: str
    answer_text: str
    status: Any = None
    budget_of: Callable[[Any], float | None] = attrgetter("time_budget_s")
    elsewhere: Lookup | None = None
    files: Sequence[ResourceFile] = ()
    file_tag: str = ""
    marks_broken_limits: bool = False
    own_delete: bool = False

    def at(self, id: str) -> str:
        """Address of one of them."""
        return f"{self.path}/{id}"

    def fields_of(self, row: AnswerRow) -> Mapping[str, Any]:
        """The fields of ``Accepted`` for a row."""
        return {
            "id": row.id,
            "name": row.name,
            "state": row.state,
            "created": in_utc(row.created),
            "links": links_to(self.path, row.id, (row.summary or {}).get("files", ())),
        }

    @property
    def plural(self) -> str:
        """What several are called."""
        return f"{self.noun[:-2]}es" if self.noun.endswith("is") else f"{self.noun}s"

    @property
    def examples(self) -> str:
        """Folder of the worked examples; those of designs stand at its top."""
        folder = self.path.removeprefix("/v1/")
        return "" if folder == "designs" else folder
