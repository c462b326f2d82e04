"""Metadata hook: a package of this tree asks for the Talaia of its own version."""

from __future__ import annotations

from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class SameVersionHook(MetadataHookInterface):
    """See the module."""

    PLUGIN_NAME = "talaia-same-version"

    def update(self, metadata: dict[str, Any]) -> None:
        """Ask for it."""
        metadata["dependencies"] = [f"talaia=={metadata['version']}"]
