"""A package's page shows the README with links and pictures that work away from its files."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import hatch_project  # noqa: E402

pytestmark = pytest.mark.pure
README = (ROOT / "README.md").read_text()
PROJECT = "https://forge.example/owner/talaia"
LINKS = re.compile(r"(!?)\[[^\]]*\]\(([^)]*)\)")


def read_addresses(project: str, site: str = "") -> dict[str, object]:
    """Give the metadata that a build with these addresses has."""
    hook = hatch_project.ProjectHook(str(ROOT), {})
    metadata: dict[str, object] = {"version": "1.2.3"}
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv(hatch_project.PROJECT, project)
        environment.setenv(hatch_project.DOCUMENTATION, site)
        hook.update(metadata)
    return metadata


def page_of(metadata: dict[str, object]) -> str:
    readme = metadata["readme"]
    assert isinstance(readme, dict)
    return str(readme["text"])


def test_each_link_of_the_readme_leads_to_a_file_of_this_tree_at_the_release_of_the_page() -> None:
    before = LINKS.findall(README)
    after = LINKS.findall(page_of(read_addresses(f"{PROJECT}/")))
    assert len(before) == len(after) > 20
    for (picture, old), (_, new) in zip(before, after, strict=True):
        kind = "raw" if picture else "blob"
        assert new == f"{PROJECT}/{kind}/v1.2.3/{old}"
        assert (ROOT / old.partition("#")[0]).is_file(), old


def test_a_page_without_an_address_has_the_words_and_no_dead_link() -> None:
    page = page_of(read_addresses(""))
    assert LINKS.findall(page) == []
    for words in ("Step by step", "**Real-time.**", "pip install 'talaia[hub,ros2]'"):
        assert words in page


def test_addresses_elsewhere_and_within_the_page_stay() -> None:
    text = "[a](https://elsewhere.example/x) ![b](https://pictures.example/y.png) [c](#below)"
    assert hatch_project.write_page(text, project="", revision="HEAD") == text


@pytest.mark.parametrize(
    ("version", "revision"),
    [("1.2.3", "v1.2.3"), ("1.2.3rc1", "v1.2.3rc1"), ("0.1.0.dev7+gabc", "HEAD")],
)
def test_only_a_release_has_a_tag_to_look_at(version: str, revision: str) -> None:
    assert hatch_project.revision_of(version) == revision


def test_a_documentation_site_comes_before_the_files() -> None:
    urls = read_addresses(PROJECT, "https://docs.example/talaia")["urls"]
    assert isinstance(urls, dict)
    assert urls["Documentation"] == "https://docs.example/talaia"
    assert urls["Source"] == PROJECT
    assert "urls" not in read_addresses("")


@pytest.mark.parametrize("address", ["forge.example/owner", "ftp://x/y", "https://", "a b"])
def test_an_address_that_leads_nowhere_ends_the_build_and_is_named(address: str) -> None:
    with pytest.raises(hatch_project.AddressError, match=r"TALAIA_PROJECT_URL is .*expected an"):
        read_addresses(address)


def test_a_release_is_built_with_the_address_of_its_own_repository() -> None:
    jobs = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())["jobs"]
    (step,) = (step for step in jobs["build"]["steps"] if "-m build" in step.get("run", ""))
    assert step["env"] == {
        hatch_project.PROJECT: "${{ github.server_url }}/${{ github.repository }}",
        hatch_project.DOCUMENTATION: "${{ vars.DOCUMENTATION_URL }}",
    }
