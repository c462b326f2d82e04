"""``talaia schema``: the JSON schema of the site description, for editors that complete YAML."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

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
    # The whole model, which --help and wrong words do not wait for.
    from talaia.extensions.installed import installed_extensions
    from talaia.model.schema import site_schema

    print(
        json.dumps(
            site_schema(installed_extensions().description_rules()), indent=2, ensure_ascii=False
        )
    )
    return 0
