"""What version a checkout, a built package and a copied folder are said to be."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from talaia import own_version as module
from talaia.own_version import UNKNOWN, version_of_checkout, version_of_tag

FILE = Path(module.__file__)


def git(place: Path, *words: str) -> str:
    who = ("-c", "user.name=Somebody", "-c", "user.email=somebody@example.org")
    words = ("git", "-C", str(place), *who, *words)
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout.strip()


def commit(place: Path) -> str:
    git(place, "commit", "--quiet", "--allow-empty", "--message", "A change")
    return git(place, "rev-parse", "--short=8", "HEAD")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A repository with Talaia's folders and one commit."""
    (tmp_path / "src/talaia").mkdir(parents=True)
    shutil.copy(FILE, tmp_path / "src/talaia/own_version.py")
    git(tmp_path, "init", "--quiet")
    commit(tmp_path)
    return tmp_path


def said_by(root: Path) -> str:
    """Ask the file as the build does: by itself, in an interpreter of its own."""
    code = "import own_version; print(own_version.own_version())"
    place = root / "src/talaia"
    words = (sys.executable, "-c", code)
    return subprocess.run(words, cwd=place, check=True, capture_output=True, text=True).stdout[:-1]


def test_a_checkout_is_named_by_its_tag_and_what_came_since(checkout: Path) -> None:
    first = git(checkout, "rev-parse", "--short=8", "HEAD")
    assert said_by(checkout) == f"0.1.0.dev1+g{first}"
    git(checkout, "tag", "v0.1.0")
    assert said_by(checkout) == "0.1.0"
    commit(checkout)
    second = commit(checkout)
    assert said_by(checkout) == f"0.1.1.dev2+g{second}"
    git(checkout, "tag", "-m", "annotated", "v0.2.0rc1")
    assert said_by(checkout) == "0.2.0rc1"
    third = commit(checkout)
    assert said_by(checkout) == f"0.2.0rc2.dev1+g{third}"
    # Of anything else nothing follows.
    git(checkout, "tag", "nightly")
    assert said_by(checkout) == f"0.2.0rc2.dev1+g{third}"


def test_a_worktree_is_a_checkout(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    git(checkout, "tag", "v3.1.4")
    beside = tmp_path_factory.mktemp("beside") / "tree"
    git(checkout, "worktree", "add", "--quiet", str(beside))
    assert version_of_checkout(beside) == "3.1.4"


def test_a_folder_inside_of_anothers_checkout_has_no_version_of_that(checkout: Path) -> None:
    git(checkout, "tag", "v9.9.9")
    inner = checkout / "vendor/talaia"
    (inner / "src/talaia").mkdir(parents=True)
    shutil.copy(FILE, inner / "src/talaia/own_version.py")
    assert said_by(inner) == UNKNOWN


def test_what_was_written_by_the_build_goes_before_git(checkout: Path) -> None:
    git(checkout, "tag", "v1.0.0")
    (checkout / "src/talaia/version.txt").write_text("0.7.0\n")
    assert said_by(checkout) == "0.7.0"


@pytest.mark.parametrize("described", ["", "v1.0", "v1.0.0-x-gabc", "v1.0.0-1-gxyz"])
def test_what_git_would_not_say_is_no_version(described: str) -> None:
    assert version_of_tag(described) == UNKNOWN


def test_the_package_itself_says_it_and_asks_git_only_then() -> None:
    code = (
        "import sys, talaia; before = 'talaia.own_version' in sys.modules; "
        "print(before, talaia.__version__ == talaia.own_version.own_version())"
    )
    words = (sys.executable, "-c", code)
    said = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    assert said == "False True\n"
