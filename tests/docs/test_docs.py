"""The documentation names what exists, and links to what is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from talaia.cli.main import COMMANDS

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
LINK = re.compile(r"!?\[[^\]]*\]\(([^)#\s]+)[^)]*\)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_and_picture_of_a_page_leads_somewhere(page: Path) -> None:
    links = [each for each in LINK.findall(page.read_text()) if "://" not in each]
    missing = [each for each in links if not (page.parent / each).exists()]
    assert missing == []


def test_the_readme_gives_the_two_commands_and_a_picture_on_its_first_screen() -> None:
    head = "\n".join((ROOT / "README.md").read_text().splitlines()[:40])
    assert "make demo" in head
    assert "make test" in head
    assert "![" in head


def test_every_word_of_the_command_line_is_in_the_reference() -> None:
    reference = (ROOT / "docs/reference/commands.md").read_text()
    assert [name for name in COMMANDS if f"## talaia {name}\n" not in reference] == []


def test_every_word_of_the_makefile_is_told_by_make_itself() -> None:
    makefile = (ROOT / "Makefile").read_text()
    phony = re.search(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)
    assert phony is not None
    for word in phony[1].split():
        if word != "help":
            assert re.search(rf"^{word}:.*## ", makefile, re.MULTILINE), word


def test_the_changelog_says_what_is_new() -> None:
    assert "## Unreleased" in (ROOT / "CHANGELOG.md").read_text()


def written_tests() -> set[str]:
    written = "".join(path.read_text() for path in ROOT.glob("tests/**/test_*.py"))
    return set(re.findall(r"^(?:async )?def (test_\w+)\(", written, re.MULTILINE))


def test_every_row_of_the_security_table_is_held_by_tests_that_exist() -> None:
    page = (ROOT / "docs/security.md").read_text()
    table = page.partition("| ASVS | topic |")[2].splitlines()[2:]
    rows = [line.strip("| ").split(" | ") for line in table if line.startswith("|")]
    assert len(rows) >= 35
    there = written_tests()
    for row in rows:
        assert len(row) == 4, row
        named = re.findall(r"`(test_\w+)`", row[3])
        assert named or "does not apply: " in row[2], row
        assert set(named) <= there, row


def test_asvs_table_names_tests_and_places_that_exist_and_lists_what_is_open() -> None:
    page = (ROOT / "docs/asvs.md").read_text()
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if re.match(r"\| \d", line)]
    assert len(rows) >= 200
    assert {len(row) for row in rows} == {5}
    assert {row[1] for row in rows} == {"1", "2"}
    assert {row[3] for row in rows} == {"yes", "part", "no", "n.a."}
    there = written_tests()
    for row in rows:
        assert set(re.findall(r"`(test_\w+)`", row[4])) <= there, row
        for place in re.findall(r"`((?:src|tests|web)/[\w./-]+)`", row[4]):
            assert (ROOT / place).exists(), row
    said = re.search(r"^Open today, in part or whole: (.*)\.$", page, re.MULTILINE)
    assert said is not None
    assert said[1].split(", ") == [row[0] for row in rows if row[3] in {"part", "no"}]


def test_each_requirement_of_the_founding_designs_is_shown_by_tests_that_exist() -> None:
    page = (ROOT / "docs/requirements.md").read_text()
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")]
    asked = [row for row in rows if row[0] not in {"id", "---"}]
    assert {len(row) for row in asked} == {4}
    assert {"R1.01.01", "R4.06.01", "hardware", "V1", "V23"} <= {row[0] for row in asked}
    there = written_tests()
    for row in asked:
        named = set(re.findall(r"`(test_\w+)`", row[3]))
        assert named or row[2] == "not there yet", row
        assert named <= there, row


def test_every_place_that_the_glossary_names_is_there() -> None:
    rows = [line for line in (ROOT / "docs/glossary.md").read_text().splitlines() if "|" in line]
    places = {
        place
        for row in rows
        for place in re.findall(r"`([\w./]+(?:/|\.py|\.ts))`", row.rpartition(" | ")[2])
    }
    assert len(places) >= 50
    there = (ROOT, ROOT / "src/talaia")
    assert [place for place in places if not any((root / place).exists() for root in there)] == []
