"""A changed `Site` back into the YAML text it came from: comments, order and spelling survive.

Only what differs is touched. A form that edits one limit must not rewrite a person's file.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import msgspec
import yaml
from ruamel.yaml.comments import CommentedMap
from ruamel.yaml.scalarstring import DoubleQuotedScalarString

from talaia.model.base import SourceShape
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.roundtrip import RESOLVER, WrittenFloat, tree_of, written_tree
from talaia.model.yaml_text.source_tags import plain_of

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = ["save_into_text"]


def save_into_text(text: str, site: Site) -> str:
    """Give ``text`` with what ``site`` has otherwise, and nothing else, changed.

    Raises:
        DescriptionError: ``text`` is not a description, or the change cannot be written into it.

    """
    before = load_site(text)
    # Equal structs may differ in the order of their keys, which is written too.
    if before == site and _key_orders(before) == _key_orders(site):
        return text
    document = tree_of(text)
    _change_struct(document, before, site)
    # Read back before anything is written: an anchor that two places share would change both,
    # and no description may ever be saved that loads as another one.
    after = written_tree(document)
    if load_site(after) != site:
        raise DescriptionError(
            "$",
            "the change cannot be written into this text",
            "anchors and aliases stand in the way",
        )
    return after


def _key_orders(value: object) -> object:
    """Give the order of every mapping: it is the order on the page, and that of the channels."""
    if isinstance(value, msgspec.Struct):
        return [_key_orders(getattr(value, field)) for field in value.__struct_fields__]
    if isinstance(value, dict):
        return [(key, _key_orders(item)) for key, item in value.items()]
    return None


def _change_struct(node: CommentedMap, old: msgspec.Struct, new: msgspec.Struct) -> None:
    for field in msgspec.structs.fields(new):
        key = field.encode_name
        was, now = getattr(old, field.name), getattr(new, field.name)
        if was == now and _key_orders(was) == _key_orders(now):
            continue
        # A default is left out, as `omit_defaults` does, so that files stay short.
        if _is_default(field, now):
            node.pop(key, None)
        else:
            node[key] = _change_node(node.get(key), was, now)


def _change_node(node: object, was: object, now: object) -> object:
    """Give what stands at a place after the change: the old node mended, or a new one."""
    # Mappings are changed in place: ruamel keeps comments on the mapping and its keys.
    if isinstance(node, CommentedMap):
        if isinstance(was, dict) and isinstance(now, dict):
            _change_mapping(node, was, now)
            return node
        if isinstance(was, SourceShape) and isinstance(now, SourceShape):
            _change_source(node, was, now)
            return node
        if isinstance(now, msgspec.Struct) and type(was) is type(now):
            assert isinstance(was, msgspec.Struct)  # noqa: S101 - the same type
            _change_struct(node, was, now)
            return node
    return _plain_value(now)


def _change_source(node: CommentedMap, old: SourceShape, new: SourceShape) -> None:
    """Mend a source key by key: which protocol's they are is not written."""
    was, now = plain_of(old), plain_of(new)
    assert isinstance(was, dict)  # noqa: S101 - a source is a mapping
    assert isinstance(now, dict)  # noqa: S101 - a source is a mapping
    for key in was.keys() - now.keys():
        node.pop(key, None)
    for key, value in now.items():
        if key not in was or was[key] != value or _key_orders(was[key]) != _key_orders(value):
            node[key] = _change_node(node.get(key), was.get(key), value)


def _change_mapping(node: CommentedMap, was: dict[str, object], now: dict[str, object]) -> None:
    for key in [key for key in node if key not in now]:
        del node[key]
    for key, value in now.items():
        if key not in was or key not in node:
            node[_key_text(key)] = _plain_value(value)
        elif was[key] != value or _key_orders(was[key]) != _key_orders(value):
            node[key] = _change_node(node[key], was[key], value)
    # Moving every key once to the end gives the new order; comments move with their keys.
    if list(node) != list(now):
        for key in now:
            node.move_to_end(key)


def _is_default(field: msgspec.structs.FieldInfo, value: object) -> bool:
    if field.default is not msgspec.NODEFAULT:
        return bool(field.default == value)
    if field.default_factory is not msgspec.NODEFAULT:
        return bool(field.default_factory() == value)
    return False


def _plain_value(value: object) -> object:
    """Turn values into what YAML has, with texts that would not come back as they are in quotes."""
    value = plain_of(value)
    if isinstance(value, dict):
        made = CommentedMap()
        for key, item in value.items():
            made[_key_text(key)] = _plain_value(item)
        return made
    if isinstance(value, list | tuple):
        return [_plain_value(item) for item in value]
    if isinstance(value, float) and math.isfinite(value):
        # YAML 1.1 knows no float without a point.
        written = repr(value)
        return WrittenFloat(written if "." in written else written.replace("e", ".0e", 1))
    return _key_text(value) if isinstance(value, str) else value


def _key_text(value: str) -> str:
    """Quote what the reader, which knows YAML 1.1, would take for a truth, a number or a time."""
    read = RESOLVER.resolve(yaml.ScalarNode, value, (True, False))  # type: ignore[no-untyped-call]
    plain = value.isprintable() and read == "tag:yaml.org,2002:str"
    return value if plain else DoubleQuotedScalarString(value)
