"""All targets; each group's module is imported when one of its targets is asked for."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .target import FuzzTarget

GROUPS = ("wire", "client", "text", "robot", "file")


def targets_in(group: str) -> tuple[FuzzTarget, ...]:
    """Give the targets of a group."""
    targets: tuple[FuzzTarget, ...] = importlib.import_module(
        f"{__package__}.{group}_targets"
    ).TARGETS
    return targets


def all_targets() -> Iterator[tuple[str, FuzzTarget]]:
    """Give every target, with its group."""
    for group in GROUPS:
        for target in targets_in(group):
            yield group, target
