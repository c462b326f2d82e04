"""The types that are installed here, with the hashes that ROS's own generator gave them."""

from __future__ import annotations

import json
import sys
from pathlib import Path

SHARE = Path(sys.prefix, "share")


def installed_types() -> dict[str, tuple[Path, str]]:
    """Give each message type's JSON file and hash, by its name."""
    found = {}
    for path in sorted(SHARE.glob("*/msg/*.json")):
        told = json.loads(path.read_bytes())
        name = told["type_description_msg"]["type_description"]["type_name"]
        hashes = {each["type_name"]: each["hash_string"] for each in told["type_hashes"]}
        found[name] = (path, hashes[name])
    return found
