"""A kept resource as one record: question, task, answer, lists and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, create_model

from service.storage.store import Lookup
from service.storage.tables import AnswerRow, in_utc
from service.wire.errors import ProblemType
from service.wire.validation import Question
from service.workers.tasks import Task, links_to
from synthesis.design.design import Status
from synthesis.design.identity import identity
from synthesis.exporters import FileContent
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
    """A file that is made of an answer, in a format of the core.

    Attributes:
        write: format, an answer's body and options to the file.
        path: the last part of its address.
        prefix: of its name in the contract. ending: of a saved file's name ("": the path).
        made_by: what decides on its bytes besides the answer and the options.
    """

    format: FileFormat[Any, Any]
    write: Callable[[FileFormat[Any, Any], bytes, Any], FileContent]
    path: str
    prefix: str = ""
    ending: str = ""
    made_by: str = ""


@dataclass(frozen=True, eq=False)
class Resource:
    """A kind of question whose answers are kept.

    Attributes:
        path: of the collection, and the kind of its answers in the store.
        tag: section of the documentation, and file_tag: of its files' ("": the same).
        noun: what one is called. id_name: what paths call the id of one.
        spec: the question. answer: what it leads to. summary: a line of the list.
        task: what a worker does; None: what the engine was made for, which is to solve designs.
        unknown: the problem of an id that does not exist.
        title, text: what the contract says of POST, and answer_text: of GET ("": as POST answers).
        status: type of the filter of lists; None: there is none.
        elsewhere: finds answers that are kept as part of something else; None: there are none.
        files: what its answers can be had as.
        marks_broken_limits: whether the files of a cam that breaks its limits are named so.
        noun_in_id: whether the noun is part of what ids are a hash of.
        own_delete: whether its routes have a DELETE of their own.
    """

    path: str
    tag: str
    noun: str
    id_name: str
    spec: type[Any]
    answer: type[BaseModel]
    summary: type[Accepted]
    task: Task | None
    unknown: ProblemType
    title: str
    text: str
    answer_text: str = ""
    status: Any = None
    elsewhere: Lookup | None = None
    files: Sequence[ResourceFile] = ()
    file_tag: str = ""
    marks_broken_limits: bool = False
    noun_in_id: bool = True
    own_delete: bool = False

    def id_of(self, spec: BaseModel | Question) -> str:
        """The id of a question."""
        return identity(*([self.noun] if self.noun_in_id else []), spec.model_dump_json())

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
