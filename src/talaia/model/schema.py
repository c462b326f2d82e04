"""The JSON schema of the site description, made from the model so that they cannot differ."""

from __future__ import annotations

import re
from inspect import cleandoc

import msgspec

from talaia.model.base import FOREIGN_KEYS, SOURCE_TAG
from talaia.model.checks.extension_rules import NO_RULES, ExtensionRules
from talaia.model.site import Site
from talaia.model.yaml_text.source_tags import SOURCES

# A line below ``Attributes:``, with the lines that are indented further behind it.
_ATTRIBUTE = re.compile(r"^ {4}(\w+): (.*(?:\n {8,}.*)*)", re.MULTILINE)

__all__ = ["site_schema"]


def site_schema(rules: ExtensionRules = NO_RULES) -> dict[str, object]:
    """Give the schema (JSON Schema 2020-12) of a whole description.

    Args:
        rules: extensions whose keys it is to know.

    """
    (reference,), parts = msgspec.json.schema_components(
        [Site], schema_hook=_allow_anything, ref_template="#/$defs/{name}"
    )
    for kind in _find_structs(msgspec.inspect.type_info(Site), {}).values():
        _add_descriptions(kind, parts[kind.__name__])
    _without_tags(parts)
    _add_extensions(parts, rules)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Talaia site description",
        **reference,
        "$defs": parts,
    }


def _find_structs(kind: object, found: dict[str, type]) -> dict[str, type]:
    """Find every shape that a type is made of, by name."""
    match kind:
        case msgspec.inspect.StructType():
            # Each shape once: a condition holds conditions, and there would be no end.
            if kind.cls.__name__ not in found:
                found[kind.cls.__name__] = kind.cls
                for field in kind.fields:
                    _find_structs(field.type, found)
        case msgspec.inspect.UnionType():
            for one in kind.types:
                _find_structs(one, found)
        case msgspec.inspect.DictType():
            _find_structs(kind.value_type, found)
        case msgspec.inspect.VarTupleType():
            _find_structs(kind.item_type, found)
        case _:
            pass
    return found


def _allow_anything(kind: type) -> dict[str, object]:
    """Say of `object` (keys that are there by mistake) that it may be anything."""
    return {"description": "anything"}


def _without_tags(parts: dict[str, dict[str, object]]) -> None:
    """Leave out what tells sources apart in the model: people do not write it."""
    sources = {shape.__name__ for shape in SOURCES}
    for name, part in parts.items():
        for key in ("properties", "required"):
            inner = part.get(key)
            if name in sources and isinstance(inner, dict):
                inner.pop(SOURCE_TAG)
                inner.pop(FOREIGN_KEYS)
            elif name in sources and isinstance(inner, list):
                # The union of sources has them as its members, wherever a source stands.
                inner.remove(SOURCE_TAG)
        _drop_discriminator(part)


def _drop_discriminator(part: object) -> None:
    """Leave out the tag of a union of sources, wherever in a part it stands."""
    if isinstance(part, dict):
        # What msgspec writes for every union that is told apart by a tag (a word of OpenAPI's).
        told = part.get("discriminator")
        if isinstance(told, dict) and told.get("propertyName") == SOURCE_TAG:
            del part["discriminator"]
        for inner in part.values():
            _drop_discriminator(inner)
    elif isinstance(part, list):
        for inner in part:
            _drop_discriminator(inner)


def _add_descriptions(kind: type, part: dict[str, object]) -> None:
    """Say of each attribute what the docstring does, where editors look for it."""
    _, _, attributes = cleandoc(kind.__doc__ or "").partition("Attributes:")
    properties = part.get("properties", {})
    if not isinstance(properties, dict):
        return
    for name, said in _ATTRIBUTE.findall(attributes):
        if name in properties:
            properties[name]["description"] = " ".join(said.replace("`", "").split())


def _add_extensions(parts: dict[str, object], rules: ExtensionRules) -> None:
    """Say which keys go with which extension, where a connection or a detector names it."""
    adapters = {name: adapter.connection for name, adapter in rules.adapters.items()}
    for part, shapes in (("ExtensionConnection", adapters), ("Watch", rules.detectors)):
        cases = []
        for name, shape in sorted(shapes.items()):
            reference = f"{part}.{name}"
            parts[reference] = _keys_schema(shape)
            # More is asked for only where the extension has this name.
            cases.append(
                {
                    "if": {
                        "properties": {"extension": {"const": name}},
                        "required": ["extension"],
                    },
                    "then": {"properties": {"keys": {"$ref": f"#/$defs/{reference}"}}},
                }
            )
        found = parts[part]
        if cases and isinstance(found, dict):
            found["allOf"] = cases


def _keys_schema(shape: type[msgspec.Struct]) -> dict[str, object]:
    _, made = msgspec.json.schema_components([shape], ref_template="#/$defs/{name}")
    part: dict[str, object] = made[shape.__name__]
    _add_descriptions(shape, part)
    return part
