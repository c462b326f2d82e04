"""A `Site` as YAML that people like to read and change: one line a source, comments on top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import yaml

from talaia.model.yaml_text.document import quoting_powers_of_ten
from talaia.model.yaml_text.source_tags import plain_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.site import Site

__all__ = ["write_description"]

# Small mappings that read better on one line.
_ON_ONE_LINE = {"source", "stop", "fixed", "ros2"}
# Never folded: a folded text may read back with other blanks in it.
_WIDTH = 1_000_000


class _OneLine(dict[str, object]):
    """A mapping that is written as ``{a: 1, b: 2}``."""


@quoting_powers_of_ten
class _Dumper(yaml.SafeDumper):
    def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:  # noqa: FBT001, FBT002
        """Indent lists below their key, as people do."""
        super().increase_indent(flow, False)  # noqa: FBT003


def _one_line(dumper: _Dumper, value: _OneLine) -> yaml.Node:
    return dumper.represent_mapping("tag:yaml.org,2002:map", value.items(), flow_style=True)


def _represent_list(dumper: _Dumper, value: list[object]) -> yaml.Node:
    flow = all(isinstance(item, str | int | float) for item in value)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", value, flow_style=flow)


def _represent_text(dumper: yaml.SafeDumper, value: str) -> yaml.Node:
    # Only double quotes can escape; the others would read a line end of Unicode's as a blank.
    style = None if value.isprintable() else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", value, style=style)


_Dumper.add_representer(str, _represent_text)
_Dumper.add_representer(_OneLine, _one_line)
_Dumper.add_representer(list, _represent_list)


def write_description(site: Site, comments: Iterable[str] = ()) -> str:
    """Write a description that `load_site` reads back to an equal one.

    Args:
        site: the description.
        comments: lines for the top of the file; what would end a comment is taken out.

    """
    plain = _with_style(plain_of(site))
    text: str = yaml.dump(plain, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=_WIDTH)
    # A name of the robot's may hold a line end; nothing unseen comes through.
    lines = ["".join(filter(str.isprintable, line)) for line in comments]
    head = "".join(f"# {line}\n" if line else "#\n" for line in lines)
    # A blank line before each device lets the eye find them.
    body = text.replace("\ndevices:\n", "\n\ndevices:\n")
    return head + body


def _with_style(value: object, key: str = "") -> object:
    if isinstance(value, dict):
        inner = {name: _with_style(item, str(name)) for name, item in value.items()}
        nested = any(isinstance(item, dict) for item in inner.values())
        return _OneLine(inner) if key in _ON_ONE_LINE and not nested else inner
    if isinstance(value, list | tuple):
        return [_with_style(item) for item in value]
    return value
