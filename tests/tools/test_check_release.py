"""Which tags may become a release."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from check_release import differences  # noqa: E402


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A repository whose newest commit has the tag v1.2.0, with what was written of it."""
    (tmp_path / "CHANGELOG.md").write_text("# C\n\n## 1.2.0\n\n- new\n")
    run_git(tmp_path, "init", "--quiet")
    run_git(tmp_path, "add", ".")
    commit_something(tmp_path)
    run_git(tmp_path, "tag", "v1.2.0")
    return tmp_path


def run_git(place: Path, *words: str) -> None:
    """Run git as somebody, whatever this machine has set."""
    who = ("-c", "user.name=Somebody", "-c", "user.email=somebody@example.org")
    subprocess.run(["git", "-C", str(place), *who, *words], check=True)


def commit_something(place: Path) -> None:
    run_git(place, "commit", "--quiet", "--allow-empty", "--message", "A change")


def test_a_release_whose_tag_is_its_version_is_made(checkout: Path) -> None:
    assert differences("v1.2.0", checkout) == []


def test_a_tag_that_is_not_checked_out_is_refused_with_every_reason(checkout: Path) -> None:
    commit_something(checkout)
    tree, changes = differences("v1.3.0", checkout)
    assert re.fullmatch(
        r"the tag is v1\.3\.0 and the checkout is 1\.2\.1\.dev1\+g[0-9a-f]{8}; check out the tag, "
        r"with all tags",
        tree,
    )
    assert "says nothing under '## 1.3.0'" in changes


@pytest.mark.parametrize("tag", ["1.2.0", "v1.2", "v1.2.0-beta", "nightly"])
def test_a_tag_of_another_form_is_refused(tag: str, checkout: Path) -> None:
    assert differences(tag, checkout) == [
        f"the tag is {tag!r}; expected one like v1.2.3 or v1.2.3rc1"
    ]
