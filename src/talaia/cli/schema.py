"""``talaia schema``: the JSON schema of the site description, for editors that complete YAML."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

from talaia.extensions.installed import installed_extensions
from talaia.model.schema import site_schema

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Print the schema."""
    argparse.ArgumentParser(
        "talaia schema",
        description="Print the JSON schema of the site description, with the keys of the"
        " extensions that are installed here.",
    ).parse_args(argv)
    print(
        json.dumps(
            site_schema(installed_extensions().description_rules()), indent=2, ensure_ascii=False
        )
    )
    return 0
