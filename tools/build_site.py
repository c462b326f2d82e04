"""Build the documentation site from `docs/`: pages, navigation, search; dead links are errors.

.venv/bin/python tools/build_site.py [--into FOLDER] [--version 1.2] [--source URL] [--site-url URL]

Zensical makes the site. What it cannot know is done here first, on a copy under `build/`:

- The navigation is `docs/README.md`: a bold line begins a section, each link of a list is a page.
- Links out of `docs/` lead to the source: `--source` is the address of the repository's files on
  a forge (`https://…/blob/v1.2`). Without one they become plain words, since the site may be read
  where no forge is reached. SECURITY.md and its neighbours come along as pages.
- With `--version` the site is written to `FOLDER/VERSION`, listed in `FOLDER/versions.json`, and
  `FOLDER/index.html` leads to the newest.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/site"
# Pages of the repository's top that readers of the documentation need, too.
TOP_PAGES = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "CODE_OF_CONDUCT.md")
PROJECT = "project"
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
ITEM = re.compile(r"([-*]|\d+\.) ")
FENCE = re.compile(r"^\s*(```|~~~)")
SECTION = re.compile(r"^\*\*(.+?)\*\*")
VERSION = re.compile(r"\d+(\.\d+)*([a-z]+\d*)?|next")
SETTINGS = """\
[project]
site_name = "Talaia"
site_description = "A self-hosted control room for robots and robotic observatories"
copyright = "Apache-2.0"
docs_dir = "pages"
site_dir = "site"
{site_url}nav = {navigation}

[project.theme]
# Fonts of the reader's own machine: the site asks no other server for anything.
font = false
features = ["navigation.indexes", "navigation.top", "content.code.copy", "search.highlight"]

[[project.theme.palette]]
media = "(prefers-color-scheme: light)"
scheme = "default"
toggle.icon = "lucide/sun"
toggle.name = "Dark"

[[project.theme.palette]]
media = "(prefers-color-scheme: dark)"
scheme = "slate"
toggle.icon = "lucide/moon"
toggle.name = "Light"
{version}"""


class SiteError(Exception):
    """The documentation cannot become a site; the text says where and why."""


@dataclass(frozen=True)
class Page:
    """One line of the navigation."""

    title: str
    path: str


@dataclass(frozen=True)
class Section:
    """A part of the navigation with its pages."""

    title: str
    pages: list[Page]


def read_navigation(text: str) -> list[Section]:
    """Read the list of pages: sections with those of their links that lead to pages.

    Args:
        text: Markdown of `docs/README.md`.

    Raises:
        SiteError: A page stands before the first section, or there is none at all.
    """
    sections: list[Section] = []
    seen = set()
    for number, line in enumerate(text.splitlines(), 1):
        if heading := SECTION.match(line):
            sections.append(Section(heading[1].removesuffix(" …"), []))
        elif line.startswith("- "):
            links = [
                Page(title[:1].upper() + title[1:].replace("`", ""), path)
                for _, title, path in LINK.findall(line)
                if path.endswith(".md") and "://" not in path
            ]
            if links and not sections:
                raise SiteError(f"docs/README.md:{number}: a page before the first section")
            # A page may be linked twice; the navigation has it where it stands first.
            fresh = [page for page in links if page.path not in seen]
            seen |= {page.path for page in fresh}
            if fresh:
                sections[-1].pages.extend(fresh)
    if not seen:
        raise SiteError("docs/README.md lists no page")
    return sections


def rewrite_links(text: str, page: Path, source: str, *, root: Path = ROOT) -> str:
    """Give a page whose links out of `docs/` lead to the source, or are plain words.

    Args:
        text: The page's Markdown.
        page: Where it stands in the repository.
        source: Address of the repository's files, without a slash at its end, or "".
        root: The repository.

    Raises:
        SiteError: A link leads to nothing.
    """
    docs = root / "docs"
    here = page if page.is_relative_to(docs) else docs / PROJECT / page.name
    out = []
    fenced = False
    for number, line in enumerate(text.split("\n"), 1):
        fenced ^= bool(FENCE.match(line))
        if fenced:
            out.append(line)
            continue

        def rewrite(match: re.Match[str], number: int = number) -> str:
            mark, words, address = match.groups()
            path, _, anchor = address.partition("#")
            if not path or "://" in address or address.startswith("mailto:"):
                return match[0]
            target = (page.parent / path).resolve()
            if not target.exists():
                raise SiteError(f"{page.relative_to(root)}:{number}: {address} leads to nothing")
            if target.is_relative_to(docs):
                place = target
            elif target.parent == root and target.name in TOP_PAGES:
                place = docs / PROJECT / target.name
            elif source:
                return f"{mark}[{words}]({source}/{target.relative_to(root).as_posix()})"
            else:
                return words
            relative = Path(os.path.relpath(place, here.parent)).as_posix()
            return f"{mark}[{words}]({relative}{'#' + anchor if anchor else ''})"

        out.append(LINK.sub(rewrite, line))
    return "\n".join(out)


def separate_blocks(text: str) -> str:
    """Give a page as Python-Markdown reads it, which asks for more room than CommonMark does.

    A list needs an empty line before it, and what belongs to an item four columns before it.
    """
    out: list[str] = []
    fence = -1
    shift = 0
    for line in text.split("\n"):
        indent = len(line) - len(line.lstrip(" "))
        if fence >= 0:
            out.append(" " * shift + line if line else line)
            fence = -1 if FENCE.match(line) else fence
            continue
        shift = 0
        # Up to seven columns are one level: nothing here is nested deeper.
        if line and 0 < indent < 4:
            shift = 4 - indent
        if FENCE.match(line):
            fence = indent
        before = out[-1] if out else ""
        starts_list = indent == 0 and ITEM.match(line) and not ITEM.match(before)
        if starts_list and before and not before.startswith(" "):
            out.append("")
        out.append(" " * shift + line)
    return "\n".join(out)


def write_pages(into: Path, source: str) -> list[Path]:
    """Copy all of `docs/` with its links rewritten, and the pages of the repository's top."""
    written = []
    docs = ROOT / "docs"
    shutil.copytree(docs, into, ignore=shutil.ignore_patterns("*.md"))
    for page in sorted(docs.rglob("*.md")):
        target = into / page.relative_to(docs)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(separate_blocks(rewrite_links(page.read_text(), page, source)))
        written.append(target)
    (into / PROJECT).mkdir()
    for name in TOP_PAGES:
        target = into / PROJECT / name
        text = rewrite_links((ROOT / name).read_text(), ROOT / name, source)
        target.write_text(separate_blocks(text))
        written.append(target)
    return written


def navigation_of(sections: list[Section], pages: set[str]) -> str:
    """Write the navigation as TOML; every page stands in it.

    Pages that no line of `docs/README.md` leads to (decisions, pages of a folder whose index is
    listed) follow the index of their folder.

    Raises:
        SiteError: A page can be reached from nowhere.
    """
    listed = {page.path for section in sections for page in section.pages} | {"README.md"}
    rest = pages - listed
    entries: list[object] = [{"Talaia": "README.md"}]
    for section in sections:
        lines: list[object] = []
        for page in section.pages:
            folder = page.path.removesuffix("README.md")
            inner = sorted(path for path in rest if path.startswith(folder))
            if folder != page.path and inner:
                rest -= set(inner)
                lines.append({page.title: [page.path, *inner]})
            else:
                lines.append({page.title: page.path})
        entries.append({section.title: lines})
    entries.append({"Project": [f"{PROJECT}/{name}" for name in TOP_PAGES]})
    rest -= {f"{PROJECT}/{name}" for name in TOP_PAGES}
    if rest:
        names = ", ".join(f"docs/{path}" for path in sorted(rest))
        raise SiteError(f"no line of docs/README.md leads to {names}: add one")
    return toml_value(entries)


def toml_value(value: object) -> str:
    """Write text, lists and tables as TOML on one line."""
    if isinstance(value, dict):
        pairs = (f"{json.dumps(key)} = {toml_value(inner)}" for key, inner in value.items())
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list):
        return f"[{', '.join(toml_value(inner) for inner in value)}]"
    return json.dumps(value, ensure_ascii=False)


def list_versions(folder: Path) -> list[str]:
    """List the versions that stand in a folder, the newest first; `next` last."""
    names = [
        path.name for path in folder.iterdir() if path.is_dir() and VERSION.fullmatch(path.name)
    ]

    def rank(name: str) -> tuple[bool, list[int], str]:
        return name != "next", [int(part) for part in re.findall(r"\d+", name)], name

    return sorted(names, key=rank, reverse=True)


def write_versions(folder: Path) -> None:
    """Write what the site's chooser of versions reads, and the page that leads to the newest."""
    versions = list_versions(folder)
    rows = [
        {"version": name, "title": name, "aliases": ["latest"] if index == 0 else []}
        for index, name in enumerate(versions)
    ]
    (folder / "versions.json").write_text(json.dumps(rows, indent=1) + "\n")
    (folder / "index.html").write_text(
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>Talaia</title>'
        f'<meta http-equiv="refresh" content="0; url={versions[0]}/">'
        f'<a href="{versions[0]}/">Documentation of Talaia {versions[0]}</a></html>\n'
    )


def build(*, into: Path, version: str, source: str, site_url: str) -> Path:
    """Build the site and put it in its place.

    Returns:
        The folder with the site's `index.html`.

    Raises:
        SiteError: A link, an anchor or a page is missing, or Zensical is.
    """
    shutil.rmtree(BUILD, ignore_errors=True)
    pages = BUILD / "pages"
    written = write_pages(pages, source)
    names = {path.relative_to(pages).as_posix() for path in written}
    sections = read_navigation((ROOT / "docs/README.md").read_text())
    address = f"{site_url.rstrip('/')}/{version + '/' if version else ''}" if site_url else ""
    settings = SETTINGS.format(
        navigation=navigation_of(sections, names),
        site_url=f'site_url = "{address}"\n' if address else "",
        version='\n[project.extra.version]\nprovider = "mike"\n' if version else "",
    )
    (BUILD / "zensical.toml").write_text(settings)
    made = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--strict"],
        cwd=BUILD, capture_output=True, text=True, check=False,
        env={**os.environ, "NO_COLOR": "1"},
    )  # fmt: skip
    if made.returncode != 0:
        said = re.sub(r"\x1b\[[0-9;]*m", "", made.stdout + made.stderr)
        raise SiteError(said.partition("Traceback (most recent call last)")[0].strip())
    target = into / version if version else into
    shutil.rmtree(target, ignore_errors=True)
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.move(BUILD / "site", target)
    if version:
        write_versions(into)
    return target


def main() -> int:
    """Build; 1 with the reason where it cannot."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--into", type=Path, default=ROOT / "build/docs")
    parser.add_argument("--version", default="", help="write FOLDER/VERSION: 1.2, or next")
    parser.add_argument("--source", default="", help="address of the repository's files")
    parser.add_argument("--site-url", default="", help="where the site will stand")
    options = parser.parse_args()
    if options.version and not VERSION.fullmatch(options.version):
        parser.error(f"--version {options.version}: expected a version such as 1.2, or next")
    try:
        target = build(
            into=options.into.resolve(), version=options.version,
            source=options.source.rstrip("/"), site_url=options.site_url,
        )  # fmt: skip
    except SiteError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{target / 'index.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
