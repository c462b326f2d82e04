"""The bases of the description's shapes."""

from __future__ import annotations

import msgspec

__all__ = ["FOREIGN_KEYS", "SOURCE_TAG", "Shape", "SourceShape"]

# Keys of the values between YAML and the model. Nobody writes them: no key has brackets.
SOURCE_TAG = "(protocol)"
FOREIGN_KEYS = "(foreign)"


class Shape(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Immutable, and a key we do not know is an error, not a silence."""


class SourceShape(Shape, frozen=True, kw_only=True, tag_field=SOURCE_TAG):
    """The base of every source.

    Its tag is never written: the connection of the device says it. See `yaml_text.source_tags`.

    Attributes:
        foreign: keys of another protocol's source that stand in this one by mistake; `check` says
            so of each, and until then they are kept as they are.

    """

    foreign: dict[str, object] = msgspec.field(default_factory=dict, name=FOREIGN_KEYS)
