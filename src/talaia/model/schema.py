"""The JSON schema of the site description, made from the model so that they cannot differ."""

from __future__ import annotations

import msgspec

from talaia.model.site import Site

__all__ = ["site_schema"]


def site_schema() -> dict[str, object]:
    """Give the schema (JSON Schema 2020-12) of a whole description."""
    (reference,), parts = msgspec.json.schema_components([Site], ref_template="#/$defs/{name}")
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Talaia site description",
        **reference,
        "$defs": parts,
    }
