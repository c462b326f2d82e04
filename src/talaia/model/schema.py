"""The JSON schema of the site description, made from the model so that they cannot differ."""

from __future__ import annotations

import re

import msgspec

from talaia.model.site import Site

_ATTRIBUTE = re.compile(r"^ {4}(\w+): (.*(?:\n {8,}.*)*)", re.MULTILINE)

__all__ = ["site_schema"]


def site_schema() -> dict[str, object]:
    """Give the schema (JSON Schema 2020-12) of a whole description."""
    (reference,), parts = msgspec.json.schema_components([Site], ref_template="#/$defs/{name}")
    for part in parts.values():
        _explain(part)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Talaia site description",
        **reference,
        "$defs": parts,
    }


def _explain(part: dict[str, object]) -> None:
    """Move what a docstring says of each attribute to where editors look for it."""
    head, _, attributes = str(part.get("description", "")).partition("Attributes:")
    if head:
        part["description"] = _in_one_line(head)
    properties = part.get("properties")
    if not isinstance(properties, dict):
        return
    for name, said in _ATTRIBUTE.findall(attributes):
        if isinstance(properties.get(name), dict):
            properties[name]["description"] = _in_one_line(said)


def _in_one_line(text: str) -> str:
    return " ".join(text.replace("``", "").replace("`", "").split())
