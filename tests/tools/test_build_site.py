"""The documentation site: navigation from the list of pages, links out of it, versions."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import build_site  # noqa: E402

pytestmark = pytest.mark.pure


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    (tmp_path / "docs/how-to").mkdir(parents=True)
    (tmp_path / "docs/tutorial.md").write_text("# Tutorial\n")
    (tmp_path / "docs/how-to/deploy.md").write_text("# Deploy\n")
    (tmp_path / "SECURITY.md").write_text("# Security\n")
    (tmp_path / "src").mkdir()
    (tmp_path / "src/hub.py").write_text("")
    return tmp_path


def rewrite(repository: Path, text: str, source: str = "") -> str:
    page = repository / "docs/how-to/deploy.md"
    return build_site.rewrite_links(text, page, source, root=repository)


def test_links_between_pages_and_to_other_servers_stay_as_they_are(repository: Path) -> None:
    text = "[a](../tutorial.md#first), [b](https://example.org/x), [c](#here), [d](deploy.md)"
    assert rewrite(repository, text) == text


def test_a_link_to_source_is_plain_words_where_no_address_of_the_source_is_known(
    repository: Path,
) -> None:
    assert rewrite(repository, "In [`hub.py`](../../src/hub.py).") == "In `hub.py`."


def test_a_link_to_source_leads_to_the_forge_where_its_address_is_known(repository: Path) -> None:
    text = rewrite(repository, "[hub](../../src/hub.py)", "https://example.org/blob/v1")
    assert text == "[hub](https://example.org/blob/v1/src/hub.py)"


def test_a_page_of_the_repositorys_top_comes_along(repository: Path) -> None:
    text = rewrite(repository, "[report](../../SECURITY.md#how)")
    assert text == "[report](../project/SECURITY.md#how)"


def test_a_link_that_leads_to_nothing_is_told_with_its_place(repository: Path) -> None:
    with pytest.raises(build_site.SiteError, match=r"docs/how-to/deploy.md:2: \.\./gone.md"):
        rewrite(repository, "one\n[two](../gone.md)")


def test_what_stands_in_a_block_of_code_is_no_link(repository: Path) -> None:
    text = "```md\n[two](../gone.md)\n```"
    assert rewrite(repository, text) == text


def test_a_list_stands_apart_and_what_belongs_to_an_item_four_columns_in() -> None:
    text = (
        "**Start**\n- one\n- two\n\n1. First\n\n   ![picture](a.png)\n\n"
        "   ```sh\n   make\n   ```\n2. Then"
    )
    assert build_site.separate_blocks(text) == (
        "**Start**\n\n- one\n- two\n\n1. First\n\n    ![picture](a.png)\n\n"
        "    ```sh\n    make\n    ```\n2. Then"
    )


def test_code_stays_as_it_was_written() -> None:
    text = "```yaml\nmap:\n  - one\n  two: 2\n- three\n```"
    assert build_site.separate_blocks(text) == text


def test_the_navigation_has_sections_and_each_page_once() -> None:
    sections = build_site.read_navigation(
        "# Talaia\n\n**Start here**\n- [the `demo`](tutorial.md): page by page\n\n"
        "**How to …**\n- [connect](a.md), or [again](tutorial.md), [the API](b.json)\n"
    )
    assert [(part.title, [(p.title, p.path) for p in part.pages]) for part in sections] == [
        ("Start here", [("The demo", "tutorial.md")]),
        ("How to", [("Connect", "a.md")]),
    ]


def test_a_page_that_no_list_leads_to_is_an_error() -> None:
    sections = [build_site.Section("Start", [build_site.Page("One", "one.md")])]
    with pytest.raises(build_site.SiteError, match=r"leads to docs/two\.md"):
        build_site.navigation_of(sections, {"README.md", "one.md", "two.md"})


def test_every_page_of_the_documentation_is_in_the_navigation() -> None:
    docs = ROOT / "docs"
    pages = {path.relative_to(docs).as_posix() for path in docs.rglob("*.md")}
    sections = build_site.read_navigation((docs / "README.md").read_text())
    written = tomllib.loads(f"nav = {build_site.navigation_of(sections, pages)}")["nav"]

    def paths(entry: object) -> list[str]:
        if isinstance(entry, str):
            return [entry]
        inner = entry.values() if isinstance(entry, dict) else entry
        assert not isinstance(inner, int)
        return [path for part in inner for path in paths(part)]  # type: ignore[attr-defined]

    project = {f"{build_site.PROJECT}/{name}" for name in build_site.TOP_PAGES}
    assert sorted(paths(written)) == sorted(pages | project)


def test_versions_are_listed_with_the_newest_first_and_what_comes_next_last(
    tmp_path: Path,
) -> None:
    for name in ("0.9", "0.10", "next", "assets"):
        (tmp_path / name).mkdir()
    build_site.write_versions(tmp_path)
    rows = json.loads((tmp_path / "versions.json").read_text())
    assert [row["version"] for row in rows] == ["0.10", "0.9", "next"]
    assert [row["aliases"] for row in rows] == [["latest"], [], []]
    assert "url=0.10/" in (tmp_path / "index.html").read_text()
