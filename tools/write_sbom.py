"""Print what Python installs beside the wheel, as CycloneDX 1.6 in JSON: write_sbom.py LOCK.

``LOCK`` is a hashed lock file of ``requirements/``. Source: CycloneDX 1.6 (ECMA-424)
and the package URLs of purl-spec (``pkg:pypi/…``).
"""

from __future__ import annotations

import json
import re
import sys
import uuid
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "src"))

from talaia import __version__  # noqa: E402

_PACKAGE = re.compile(
    r"(?m)^(?P<name>[A-Za-z0-9._-]+)==(?P<version>[^\s;\\]+)(?P<rest>.*(?:\n .*)*)"
)
_HASH = re.compile(r"--hash=sha256:([0-9a-f]{64})")


def write_sbom(lock: str) -> dict[str, Any]:
    """Give the document of a lock file's text; the same text gives the same document.

    Raises:
        ValueError: a package has no hash, or there is none at all.

    """
    components = []
    for found in _PACKAGE.finditer(lock):
        name, version = found["name"].lower(), found["version"]
        hashes = _HASH.findall(found["rest"])
        if not hashes:
            raise ValueError(f"{name} {version} has no hash; a lock file is made by `make lock`")
        url = f"pkg:pypi/{name}@{version}"
        # A lock holds the hash of every wheel of a version; which of them is installed depends on
        # the machine, so they are told as what each distribution may be.
        files = [
            {"type": "distribution", "url": url, "hashes": [{"alg": "SHA-256", "content": digest}]}
            for digest in hashes
        ]
        components.append(
            {
                "type": "library",
                "bom-ref": url,
                "name": name,
                "version": version,
                "purl": url,
                "externalReferences": files,
            }
        )
    if not components:
        raise ValueError("the file names no package; give a lock file of requirements/")
    own = f"pkg:pypi/talaia@{__version__}"
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, own + lock)}",
        "version": 1,
        "metadata": {
            "component": {
                "type": "application",
                "bom-ref": own,
                "name": "talaia",
                "version": __version__,
                "purl": own,
                "licenses": [{"license": {"id": "Apache-2.0"}}],
            }
        },
        "components": components,
    }


def main(arguments: list[str]) -> int:
    """Print the document; 2 when the file is no lock file."""
    if len(arguments) != 1:
        print("give one lock file: tools/write_sbom.py requirements/demo.txt", file=sys.stderr)
        return 2
    try:
        document = write_sbom(Path(arguments[0]).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        print(f"{arguments[0]}: {error}", file=sys.stderr)
        return 2
    print(json.dumps(document, indent=2))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
