"""Every number has a reason, and one page shows them all."""

from tests.architecture.constants import TARGET, constants, page


def test_every_constant_has_a_reason() -> None:
    bare = [f"{one.module}: {', '.join(one.names)}" for one in constants() if not one.reason]
    assert bare == [], "write unit and reason behind the value"


def test_the_page_of_constants_is_that_of_the_modules() -> None:
    assert TARGET.read_text("utf-8") == page(), "run `make constants`"
