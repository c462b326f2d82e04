"""An older description's text as it is written today. Pure; comments and order survive.

A step changes the tree of a text: what another version wrote otherwise, or a spelling that is
still read but no longer written. A new version of the format adds its steps at the end and raises
`version.FORMAT`; no step is ever taken out, so that any description of any time can be brought up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping
from typing import NamedTuple, TypeAlias

import yaml

from talaia.model.errors import DescriptionError, NotReadable
from talaia.model.yaml_text.document import document_of
from talaia.model.yaml_text.roundtrip import tree_of, written_tree
from talaia.model.yaml_text.version import FORMAT, OLDEST, version_of

__all__ = ["STEPS", "Tree", "UpgradeStep", "Upgraded", "upgrade_text"]

Tree: TypeAlias = MutableMapping[str, object]


class UpgradeStep(NamedTuple):
    """One change of the format.

    Attributes:
        version: the version in which it came; a description of that version may still have the
            older spelling, so a step must leave alone what is changed already.
        change: changes a tree in place and says of each change where it was and what it is now.

    """

    version: int
    change: Callable[[Tree], Iterator[str]]


class Upgraded(NamedTuple):
    """The text as it is written today, and of each change where and what."""

    text: str
    changes: tuple[str, ...]


def _link_loss_holds(tree: Tree) -> Iterator[str]:
    """``link_loss: nothing`` said what does not happen; ``hold`` says what does."""
    for name, device in _inner_mappings(tree.get("devices")):
        drive = device.get("drive")
        if isinstance(drive, MutableMapping) and drive.get("link_loss") == "nothing":
            drive["link_loss"] = "hold"
            yield f"$.devices.{name}.drive.link_loss: nothing is now written hold"


STEPS: tuple[UpgradeStep, ...] = (UpgradeStep(1, _link_loss_holds),)


def upgrade_text(
    text: str, steps: tuple[UpgradeStep, ...] = STEPS, newest: int = FORMAT
) -> Upgraded:
    """Bring a text to the newest version.

    Args:
        text: a description of any version.
        steps: in the order in which they came.
        newest: the version they lead to.

    Raises:
        DescriptionError: it is no description, is newer than ``newest``, or cannot be changed
            without changing what else it says (aliases: two places that are one).

    """
    # On plain values first: whether anything is to be changed, and what must come out.
    wanted = _parse_tree(text)
    version = version_of(wanted.get("talaia"), newest, OLDEST)
    # Steps of its own version as well: it may still have the older spelling.
    due = [step for step in steps if step.version >= version]
    changes = _apply_steps(wanted, due, version, newest)
    if not changes:
        # To the last blank as it was.
        return Upgraded(text, ())
    tree = tree_of(text)
    _apply_steps(tree, due, version, newest)
    after = written_tree(tree)
    if "\r\n" in text:
        after = after.replace("\n", "\r\n")
    # Read back before it is given: behind an alias another place may have changed, too.
    if _parse_tree(after) != wanted:
        raise DescriptionError(
            "$",
            "it cannot be changed here without changing more of it",
            f"change by hand: {'; '.join(changes)}",
        )
    return Upgraded(after, tuple(changes))


def _parse_tree(text: str) -> dict[str, object]:
    try:
        document = document_of(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise NotReadable("$", f"is not YAML: {error}") from error
    if not isinstance(document, dict):
        raise DescriptionError("$", "expected a mapping with the keys talaia, site, name, devices")
    return document


def _apply_steps(tree: Tree, steps: list[UpgradeStep], version: int, newest: int) -> list[str]:
    changes = [said for step in steps for said in step.change(tree)]
    if version != newest:
        tree["talaia"] = newest
        changes.append(f"$.talaia: {version} is now {newest}")
    return changes


def _inner_mappings(value: object) -> Iterator[tuple[str, Tree]]:
    """Give the mappings in a mapping, whatever else stands there."""
    if isinstance(value, MutableMapping):
        for name, child in value.items():
            if isinstance(child, MutableMapping):
                yield str(name), child
