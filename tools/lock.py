"""Resolve pyproject.toml into the hashed lock files of requirements/; names no host."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOCKS = {
    "dev.txt": ["--extra", "dev"],
    "demo.txt": [
        "--extra",
        "hub",
        "--extra",
        "sim",
        "--extra",
        "observatory",
        "--extra",
        "recording",
        "--extra",
        "camera",
        "--extra",
        "objects",
        "--extra",
        "configurator",
    ],
}
ALWAYS = "hatchling>=1.27\neditables>=0.5\n"  # both for the editable install


def main() -> int:
    """Write every lock file; `demo.txt` agrees with `dev.txt` on every version."""
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", "uv"], check=True)
    with tempfile.TemporaryDirectory() as folder:
        always = Path(folder, "always.in")
        always.write_text(ALWAYS)
        for name, extras in LOCKS.items():
            target = ROOT / "requirements" / name
            command = [
                sys.executable, "-m", "uv", "pip", "compile", "pyproject.toml", str(always),
                *extras, "--universal", "--python-version", "3.11", "--generate-hashes",
                "--no-emit-index-url", "--no-emit-find-links", "--no-annotate", "--no-header",
                "--quiet", "--output-file", str(target),
            ]  # fmt: skip
            if name != "dev.txt":
                command += ["--constraint", str(ROOT / "requirements" / "dev.txt")]
            subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
            text = target.read_text()
            if "://" in text:
                print(f"{target} names a host", file=sys.stderr)
                return 1
            count = len(re.findall(r"(?m)^[a-z0-9].*==", text))
            print(f"{target.relative_to(ROOT)}: {count} packages")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
