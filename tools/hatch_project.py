"""Metadata hook: a package's page shows the README with links and pictures that work there.

A README's links are relative, and a package index has no files beside it. Where the project lives
is set by whoever releases it: ``TALAIA_PROJECT_URL``, as ``https://forge.example/owner/talaia``,
and ``TALAIA_DOCUMENTATION_URL`` for the documentation site, if there is one. Without them the page
says the same, without links and pictures that would be dead.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from hatchling.metadata.plugin.interface import MetadataHookInterface

PROJECT, DOCUMENTATION = "TALAIA_PROJECT_URL", "TALAIA_DOCUMENTATION_URL"
LINK = re.compile(r"(?P<picture>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")
RELEASE = re.compile(r"\d+(\.\d+)*((a|b|rc)\d+)?")


class AddressError(ValueError):
    """An address that no page could link to."""

    def __init__(self, name: str, value: str) -> None:
        """Name the variable and what it says."""
        super().__init__(
            f"{name} is {value!r}; expected an address such as https://forge.example/owner/talaia"
        )


class ProjectHook(MetadataHookInterface):
    """See the module."""

    PLUGIN_NAME = "talaia-project"

    def update(self, metadata: dict[str, Any]) -> None:
        """Give the README as a package's page shows it, and the project's addresses."""
        project, site = read_address(PROJECT), read_address(DOCUMENTATION)
        revision = revision_of(metadata["version"])
        text = Path(self.root, "README.md").read_text(encoding="utf-8")
        metadata["readme"] = {
            "content-type": "text/markdown",
            "text": write_page(text, project=project, revision=revision),
        }
        if urls := project_urls(project=project, site=site, revision=revision):
            metadata["urls"] = urls


def read_address(name: str) -> str:
    """Read an address from the environment; nothing where it is not set.

    Raises:
        AddressError: it is no address of a web page.

    """
    value = os.environ.get(name, "").strip().rstrip("/")
    if not value:
        return ""
    parts = urlsplit(value)
    if parts.scheme not in ("http", "https") or not parts.netloc or parts.query or parts.fragment:
        raise AddressError(name, value)
    return value


def revision_of(version: str) -> str:
    """Give what a forge shows the files of: a release's tag, or else the newest."""
    return f"v{version}" if RELEASE.fullmatch(version) else "HEAD"


def project_urls(*, project: str, site: str, revision: str) -> dict[str, str]:
    """Give the addresses beside a package's page, by their well-known labels.

    The labels are those of packaging.python.org, "Well-known Project URLs in Metadata".
    """
    urls: dict[str, str] = {}
    if project:
        urls = {
            "Homepage": project,
            "Source": project,
            "Issues": f"{project}/issues",
            "Changelog": f"{project}/blob/{revision}/CHANGELOG.md",
            "Documentation": f"{project}/blob/{revision}/docs/README.md",
        }
    return urls | ({"Documentation": site} if site else {})


def write_page(text: str, *, project: str, revision: str) -> str:
    """Write a README as it can stand away from its files.

    Args:
        text: Markdown.
        project: the project's address on a forge, or nothing: then relative links become their
            words, and pictures are left out.
        revision: a tag or a branch, see `revision_of`.

    """

    def replace(link: re.Match[str]) -> str:
        picture, words, target = link["picture"], link["text"], link["target"]
        if not re.match(r"[a-z]+:|#", target):
            kind = "raw" if picture else "blob"
            target = f"{project}/{kind}/{revision}/{target}" if project else ""
        if target:
            return f"{picture}[{words}]({target})"
        return "" if picture else words

    return LINK.sub(replace, text)
