"""Bad cams get the right word first; a good one, and a limit set on purpose, none."""

from __future__ import annotations

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design
from synthesis.design.warnings import SEVERITIES
from synthesis.pipeline.advice import RULES
from tests.pipeline.advice.bad_cams import FIRST, GOOD
from tests.pipeline.advice.page import TARGET, page


def designed(body: dict) -> Design:
    return synthesise(DesignSpec.model_validate(body))


def said(body: dict) -> list[tuple[str, str]]:
    return [(one.code, one.severity) for one in designed(body).warnings]


@pytest.mark.parametrize("name", FIRST)
def test_a_bad_cam_gets_the_right_word_first(name: str) -> None:
    code, severity, body = FIRST[name]
    design = designed(body)
    first = design.warnings[0]
    assert (first.code, first.severity) == (code, severity), design.warnings
    assert design.severity == severity
    ranks = [SEVERITIES.index(one.severity) for one in design.warnings]
    assert ranks == sorted(ranks, reverse=True)
    for one in design.warnings:  # read aloud: sentences, with a value and what to change
        assert one.sentence.endswith(".")
        assert one.remedy.endswith(".")
        assert one.source


def test_nothing_is_said_of_a_good_cam() -> None:
    design = designed(GOOD)
    assert (design.warnings, design.severity) == ([], "none")


def test_the_page_is_made_of_the_rules() -> None:
    assert TARGET.read_text("utf-8") == page()
    assert len({rule.code for rule in RULES}) == len(RULES)
