"""What is kept by id: questions with their answers.

In comes a question, a model of the core; out goes its answer, a row of the store with the bytes of
the response. A resource is one record (`resource.Resource`): its path, the models of question and
answer, the task that a worker runs, the lines of lists, its files. `designs`, `cam_sets` and
`machines` hold the records, `RESOURCES` has them all by path. `jobs.Jobs` runs the questions of one
resource, shares work on the same question and keeps the answers; `routes/resource_routes.py` makes
the routes of any. A new kind of question is a record and a task in `workers/tasks.py`. Begin with
`designs.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from service.resources.cam_sets import CAM_SETS
from service.resources.designs import ANALYSES, DESIGNS, PROFILE_ANALYSES
from service.resources.machines import LINKAGE_RESOURCES, SPATIAL_CAMS, TRAIN_RESPONSES
from service.resources.resource import Resource

ALL = (
    DESIGNS, CAM_SETS, ANALYSES, PROFILE_ANALYSES, SPATIAL_CAMS, TRAIN_RESPONSES,
    *LINKAGE_RESOURCES,
)  # fmt: skip
RESOURCES: Mapping[str, Resource] = MappingProxyType({each.path: each for each in ALL})
