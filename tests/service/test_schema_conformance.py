"""Schemathesis sends what the schema allows, and what it forbids; answers must be as documented."""

from __future__ import annotations

import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis.checks import CHECKS, load_all_checks

from service.app import create_app
from service.settings import Settings
from tests.service.conftest import Running

load_all_checks()
# A program that does not close fits the schema and is refused all the same.
NOT_ASKED = CHECKS.get_by_names(["positive_data_acceptance"])


schema = schemathesis.openapi.from_dict(create_app(Settings()).openapi())


@schema.parametrize()
@settings(
    max_examples=15, deadline=None, derandomize=True, database=None,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
def test_answers_are_as_documented(case: schemathesis.Case, service: Running) -> None:
    case.call_and_validate(base_url=service.url, excluded_checks=NOT_ASKED)
