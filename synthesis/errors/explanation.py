"""Errors of a model that is made in Python, in the words of the service."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from synthesis.errors.violations import MAX_LISTED, PYDANTICS_OWN, find_causes


def explained(error: ValidationError, model: type[BaseModel], body: Any) -> ValidationError:
    """The error of a body with rules and remedies in place of pydantic's texts.

    Those of the core alone, which have both, are left as they are, and so are very many.
    """
    errors = error.errors(include_url=False) if error.error_count() <= MAX_LISTED else []
    if not any(each["type"] in PYDANTICS_OWN for each in errors):
        return error

    def errors_of(changed: Any) -> Sequence[Any]:
        try:
            model.__pydantic_validator__.validate_python(changed)
        except ValidationError as later:
            return later.errors(include_url=False)
        return ()

    found, _ = find_causes(errors, body, model, errors_of)
    return ValidationError.from_exception_data(
        error.title,
        [
            InitErrorDetails(
                type=PydanticCustomError(
                    each.kind, "{said}", {"said": f"{each.rule.rstrip('.')}. {each.remedy}"}
                ),
                loc=each.path,
                input=each.value,
            )
            for each in found
        ],
    )
