"""YAML that is changed and written again: comments, order, quotes and numbers stay as they were."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import yaml
from ruamel.yaml import YAML
from ruamel.yaml.constructor import RoundTripConstructor
from ruamel.yaml.error import YAMLError
from ruamel.yaml.representer import RoundTripRepresenter

from talaia.model.errors import NotReadable
from talaia.model.yaml_text.document import quoting_powers_of_ten

if TYPE_CHECKING:
    from ruamel.yaml.comments import CommentedMap

__all__ = ["RESOLVER", "WrittenFloat", "tree_of", "written_tree"]


# What another reader of the text would take a plain word for.
@quoting_powers_of_ten
class _Words(yaml.resolver.Resolver):
    """YAML's own words, and ours."""


RESOLVER = _Words()
_FLOAT = "tag:yaml.org,2002:float"


class WrittenFloat(str):
    """A number as it is written: read and written again, its last digit could change."""

    __slots__ = ()


class _Constructor(RoundTripConstructor):
    """Keeps numbers as they are written."""


class _Representer(RoundTripRepresenter):
    """Writes them so."""


def _construct_float(_: _Constructor, node: yaml.ScalarNode) -> WrittenFloat:
    return WrittenFloat(node.value)


def _represent_float(representer: _Representer, value: WrittenFloat) -> object:
    return representer.represent_scalar(_FLOAT, str(value))


# On classes of our own: ruamel's are shared with everybody in this process.
_Constructor.add_constructor(_FLOAT, _construct_float)
_Representer.add_representer(WrittenFloat, _represent_float)


def _make_yaml() -> YAML:
    made = YAML(typ="rt")
    made.Constructor = _Constructor
    made.Representer = _Representer
    made.preserve_quotes = True
    # Never folded; see `write`.
    made.width = 1_000_000
    made.indent(mapping=2, sequence=4, offset=2)
    return made


def tree_of(text: str) -> CommentedMap:
    """Read a text that `load.load_site` or `document.document_of` could read.

    Raises:
        NotReadable: it is read otherwise here than there.

    """
    try:
        # ruamel writes line ends of its own; `upgrade_text` puts these back.
        tree: CommentedMap = _make_yaml().load(text.replace("\r\n", "\n"))
    except YAMLError as error:
        raise NotReadable("$", f"is not YAML: {error}") from error
    return tree


def written_tree(tree: CommentedMap) -> str:
    """Write a tree that `tree_of` gave."""
    out = io.StringIO()
    _make_yaml().dump(tree, out)
    return out.getvalue()
