"""/v1/train-responses: what an elastic follower train does on a cam."""

from __future__ import annotations

from functools import partial
from typing import Any

from service.resources.resource import Resource, file_of
from service.resources.views import TrainResponsePage
from service.wire.errors import ProblemType
from service.wire.links import train_links
from service.workers.tasks import compute_train_response
from synthesis.design.identity import question_id
from synthesis.exporters import Made
from synthesis.exporters.exporter import FileFormat
from synthesis.machines.dynamics import TrainResponse, TrainSpec
from synthesis.machines.dynamics.files import TRAIN_FILES


def _file(file: FileFormat[TrainResponse, Any], body: bytes, options: Any) -> Made:
    return file.whole(TrainResponse.model_validate_json(body), options)


TRAIN_RESPONSES = Resource(
    path="/v1/train-responses",
    tag="follower trains",
    noun="train response",
    plural="train responses",
    id_name="train_id",
    spec=TrainSpec,
    answer=TrainResponse,
    page=TrainResponsePage,
    examples="train-responses",
    id_of=lambda spec: question_id(spec, "train response"),
    task=compute_train_response,
    links=lambda id, _: train_links(id),
    unknown=ProblemType.UNKNOWN_TRAIN_RESPONSE,
    title="Respond to a cam with an elastic follower train",
    text="""Residual vibration in each dwell, contact force, loss of contact; exact but rounding.

    The train is a chain of masses, springs and dampers that the cam drives through the first link.
    Its periodic response and its way there from rest are computed mode by mode in closed form. The
    cam's own limits are its spec's; a law without residual vibration: the limit
    `residual_vibration`. The same spec gives the same bytes.
    """,
    answer_text="As `POST /v1/train-responses` answered, or would have without `respond-async`.",
    files=tuple(
        file_of(file, file.name, f"train_{file.name.replace('.', '_')}", partial(_file, file))
        for file in TRAIN_FILES
    ),
)
