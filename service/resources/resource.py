"""A kept resource as one record: question, task, answer, lists and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from pydantic import BaseModel

from service.resources.views import Page
from service.storage.store import Lookup
from service.wire.errors import ProblemType
from service.workers.tasks import Task
from synthesis.exporters import Made, form
from synthesis.exporters.exporter import FileFormat


def _unchanged(query: Any) -> Any:
    return query


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
    make: Callable[[bytes, Any], Made]
    purpose: str = ""
    options_of: Callable[[Any], Any] = _unchanged
    in_worker: bool = False
    download_name: str = ""
    made_by: str = ""


def file_of(
    exporter: FileFormat[Any, Any],
    path: str,
    operation: str,
    make: Callable[[bytes, Any], Made],
    **more: Any,
) -> ResourceFile:
    """A file in a format of the core. ``more``: fields of ``ResourceFile`` that differ."""
    fields: dict[str, Any] = {
        "title": exporter.title,
        "purpose": exporter.purpose,
        "in_worker": exporter.apart,
        "download_name": path,
    }
    return ResourceFile(
        path=path,
        operation=operation,
        media_type=exporter.media_type,
        query=form(exporter.options),
        options_of=lambda query: exporter.options(**dict(query)),
        make=make,
        **(fields | more),
    )


@dataclass(frozen=True, eq=False)
class Resource:
    """A kind of question whose answers are kept.

    Attributes:
        path: of the collection, and the kind of its answers in the store.
        tag: section of the documentation, and file_tag: of its files' ("": the same).
        noun: what one is called, and plural. id_name: what paths call the id of one.
        spec: the question. answer: what it leads to. page: of the list.
        examples: folder of the worked examples.
        id_of: question to id.
        task: what a worker does; None: what the engine was made for, which is to solve designs.
        links: id, and what lists show of the answer, to addresses.
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
    plural: str
    id_name: str
    spec: type[Any]
    answer: type[BaseModel]
    page: type[Page[Any]]
    examples: str
    id_of: Callable[[Any], str]
    task: Task | None
    links: Callable[[str, Mapping[str, Any]], dict[str, str]]
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

    @property
    def operation(self) -> str:
        """What operations call one, as in ``get_cam_set``."""
        return self.noun.replace(" ", "_").replace("-", "_")

    @property
    def operations(self) -> str:
        """What operations call several, as in ``list_cam_sets``."""
        return self.plural.replace(" ", "_").replace("-", "_")
