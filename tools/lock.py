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
        "arrow",
        "--extra",
        "chats",
        "--extra",
        "fast",
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
# What an image of `talaia generate` may install, group by group: the extras that it knows, what
# builds empy (which has no wheel), and uv. In one file that travels in the wheel.
IMAGES = ROOT / "src/talaia/deploy/images.lock"
IMAGE_EXTRAS = (
    "hub", "arrow", "chats", "fast", "mariadb", "postgresql", "cluster", "s3", "objects", "gateway",
    "ros2", "recording", "camera", "observatory",
)  # fmt: skip
OTHER_GROUPS = {"build": "setuptools\n", "uv": "uv\n"}
COMPILE = (
    "--universal", "--generate-hashes", "--no-emit-index-url", "--no-emit-find-links",
    "--no-annotate", "--no-header", "--quiet",
)  # fmt: skip


def main() -> int:
    """Write every lock file; `demo.txt` agrees with `dev.txt` on every version."""
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", "uv"], check=True)
    with tempfile.TemporaryDirectory() as folder:
        project = without_own_packages(Path(folder))
        always = Path(folder, "always.in")
        always.write_text(ALWAYS)
        for name, extras in LOCKS.items():
            target = ROOT / "requirements" / name
            command = [
                sys.executable, "-m", "uv", "pip", "compile", str(project), str(always),
                *extras, *COMPILE, "--python-version", "3.11", "--output-file", str(target),
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
        write_image_lock(Path(folder), project)
    return 0


def without_own_packages(folder: Path) -> Path:
    """Copy the project's file without the packages of this tree, which no index needs to have."""
    text = (ROOT / "pyproject.toml").read_text()
    copy = folder / "pyproject.toml"
    copy.write_text(re.sub(r'(?m)^ +"talaia-[^"]+",\n', "", text))
    return copy


def write_image_lock(folder: Path, project: Path) -> None:
    """Write what images install: each package once, with the groups that need it."""
    groups: dict[str, set[str]] = {}
    for group in (*IMAGE_EXTRAS, *OTHER_GROUPS):
        if group in OTHER_GROUPS:
            source = folder / f"{group}.in"
            source.write_text(OTHER_GROUPS[group])
            words = [str(source)]
        else:
            words = [str(project), "--extra", group]
        made = folder / f"{group}.txt"
        # Of versions that stand there already uv keeps all hashes, also of wheels for platforms
        # that the index at hand does not show.
        made.write_text((ROOT / "requirements/dev.txt").read_text())
        # For the Python of images, and for that of the tests, which install by it, too.
        more = ["--python-version", "3.11", "--constraint", str(ROOT / "requirements/dev.txt")]
        subprocess.run(
            [
                sys.executable, "-m", "uv", "pip", "compile", *words, *COMPILE, *more,
                "--output-file", str(made),
            ],
            check=True,
            cwd=ROOT,
            stdout=subprocess.DEVNULL,
        )  # fmt: skip
        for block in re.findall(r"(?m)^\S+==[^\\\n]*(?:\\\n +--hash=\S+ ?)+", made.read_text()):
            groups.setdefault(block, set()).add(group)
    blocks = sorted(f"# {' '.join(sorted(names))}\n{text}\n" for text, names in groups.items())
    blocks.sort(key=lambda block: block.partition("\n")[2])
    head = (
        "# Made by `make lock`: what images of `talaia generate` install, and for which extras.\n\n"
    )
    IMAGES.write_text(head + "".join(blocks))
    print(f"{IMAGES.relative_to(ROOT)}: {len(blocks)} packages")


if __name__ == "__main__":
    raise SystemExit(main())
