"""JSON Schema, as far as checker/proof.schema.json uses it; a keyword beyond that is an error."""

from typing import Any

TYPES: dict[str, Any] = {
    "null": type(None), "object": dict, "array": list, "string": str, "boolean": bool,
    "number": (int, float), "integer": int,
}  # fmt: skip
KEYWORDS = {
    "type", "const", "enum", "required", "properties", "items", "anyOf", "if", "then", "minimum",
    "maximum", "minItems", "maxItems", "minLength", "$ref", "$schema", "$defs", "title",
    "description",
}  # fmt: skip


def conforms(value: Any, schema: Any, root: Any) -> bool:
    """Whether a value is as a schema says."""
    assert set(schema) <= KEYWORDS, set(schema) - KEYWORDS

    def fits(part: Any, own: Any) -> bool:
        return conforms(part, own, root)

    if "$ref" in schema:
        schema = root["$defs"][schema["$ref"].removeprefix("#/$defs/")]
    kind = schema.get("type")
    if kind and not isinstance(value, TYPES[kind]):
        return False
    if isinstance(value, bool) and kind in ("number", "integer"):
        return False
    found = [value in schema.get("enum", [value]), value == schema.get("const", value)]
    found += [
        not (isinstance(value, bool) and {"enum", "const"} & set(schema))
        or value is schema.get("const")
    ]
    if isinstance(value, dict):
        known = schema.get("properties", {})
        found += [set(schema.get("required", [])) <= set(value)]
        found += [fits(part, known[name]) for name, part in value.items() if name in known]
    elif isinstance(value, list):
        found += [schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))]
        found += [fits(part, schema.get("items", {})) for part in value]
    elif isinstance(value, str):
        found += [len(value) >= schema.get("minLength", 0)]
    elif isinstance(value, (int, float)):
        found += [schema.get("minimum", value) <= value <= schema.get("maximum", value)]
    if "anyOf" in schema:
        found += [any(fits(value, own) for own in schema["anyOf"])]
    if "if" in schema and fits(value, schema["if"]):
        found += [fits(value, schema["then"])]
    return all(found)
