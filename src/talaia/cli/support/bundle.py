"""A support bundle: what it holds, cleaned of secrets, as one ZIP file."""

from __future__ import annotations

import os
import zipfile
from typing import TYPE_CHECKING, NamedTuple

import yaml

from talaia.cli.errors import CliError
from talaia.cli.examining.host import running_programs
from talaia.cli.support.hub_facts import describe_health, read_database
from talaia.cli.support.known_secrets import (
    secrets_in_environment,
    secrets_in_files,
    secrets_in_tree,
    secrets_in_url,
)
from talaia.cli.support.machine_facts import (
    describe_doctor,
    describe_files,
    describe_programs,
    describe_versions,
    environment_of,
    read_journal,
    read_log,
)
from talaia.cli.support.redaction import MASK, Redactor
from talaia.errors import TalaiaError
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.document import require_shallow
from talaia.model.yaml_text.load import load_site, text_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

__all__ = ["BundleSources", "bundle_texts", "write_bundle"]

_README = f"""\
A support bundle of Talaia, made by `talaia support-bundle`.

Secrets were masked as {MASK}: passwords, tokens and keys by their names and their forms, arguments
of programs, what stands in the key files of this installation, wherever it stood, and mail
addresses. Names of sites, devices and signals, host names and network addresses are in it. Look
through it before you hand it on: what people wrote into a description may be something that no
program knows for a secret.

versions.txt    Talaia, Python, the machine, installed packages
doctor.txt      what `talaia doctor` says
programs.txt    Talaia's programs that run here
settings.txt    variables of the environment, and settings files
health.txt      whether the hub answers
database.txt    kind, form and size of the database, rows of each table
gateways.txt    gateways with their versions
files.txt       files of the data folder with their sizes
site/           descriptions without comments, and what `talaia check` finds in them
logs/           the last lines of each log
"""


class BundleSources(NamedTuple):
    """From where a bundle is made.

    Attributes:
        data: the hub's data folder.
        port: of the hub on this machine.
        database_url: of the hub's database.
        sites: site descriptions.
        settings: files of settings, and those that they name.
        logs: files of logs, beside those in the data folder and systemd's journal.
        environment: variables of this process.

    """

    data: Path
    port: int
    database_url: str
    sites: tuple[Path, ...]
    settings: tuple[Path, ...]
    logs: tuple[Path, ...]
    environment: Mapping[str, str]


def bundle_texts(sources: BundleSources) -> dict[str, str]:
    """Give the files of a bundle by name, without any secret that is known or looks like one."""
    programs = [found for found in running_programs() if found.pid != os.getpid()]
    environments = [sources.environment, *(environment_of(found.pid) for found in programs)]
    trees = {path: _read_tree(path) for path in (*sources.sites, *sources.settings)}
    redactor = Redactor()
    # All of them before the first text is cleaned: a key in one file may be named in another.
    redactor.learn(secrets_in_files([sources.data, sources.data / "tls"]))
    redactor.learn(secrets_in_url(sources.database_url))
    for environment in environments:
        redactor.learn(secrets_in_environment(environment))
    for path, tree in trees.items():
        redactor.learn(secrets_in_tree(tree, path.parent, sources.environment))
    # Opened for reading alone; the hub may be writing.
    database = read_database(sources.database_url)
    texts = {
        "versions.txt": describe_versions(),
        "doctor.txt": describe_doctor(sources.data, sources.port),
        "programs.txt": describe_programs(programs, redactor),
        "settings.txt": _describe_settings(sources, environments, trees, redactor),
        "health.txt": describe_health(sources.data, sources.port),
        "database.txt": database.sizes,
        "gateways.txt": database.gateways,
        "files.txt": describe_files(sources.data),
    }
    for path in sources.sites:
        name = _free_name(texts, f"site/{path.name}")
        texts[name] = _tree_text(trees[path], redactor)
        texts[f"{name}.check.txt"] = _check_text(path)
    for path in (*sorted(sources.data.glob("*.log")), *sources.logs):
        texts[_free_name(texts, f"logs/{path.name}")] = read_log(path)
    # Where systemd runs no unit of ours there is none.
    journal = read_journal()
    if journal:
        texts["logs/journal.txt"] = journal
    # Each once more, whoever wrote it: a version in a list of packages is no random word.
    cleaned = {
        name: redactor.mask_known(text) if name == "versions.txt" else redactor.clean_text(text)
        for name, text in texts.items()
    }
    for name, text in cleaned.items():
        if redactor.find_known(text):
            raise CliError(f"{name} still has a secret in it; no bundle was made: tell us of it")
    return {"README.txt": _README, **cleaned}


def write_bundle(texts: Mapping[str, str], target: Path) -> None:
    """Write the files into a ZIP that only its owner can read, and that is not there yet.

    Raises:
        CliError: it is there, or cannot be written.

    """
    try:
        number = os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        with os.fdopen(number, "wb") as file, zipfile.ZipFile(file, "w") as archive:
            for name, text in texts.items():
                archive.writestr(name, text, zipfile.ZIP_DEFLATED)
    except OSError as error:
        raise CliError(f"{target} cannot be written: {error.strerror}") from error


def _free_name(texts: Mapping[str, str], name: str) -> str:
    """Give a name that no other file of the bundle has."""
    number, free = 2, name
    while free in texts:
        free, number = f"{name}.{number}", number + 1
    return free


def _read_tree(path: Path) -> object:
    try:
        text = text_of(path)
        require_shallow(text)
        read: object = yaml.safe_load(text)
    except (TalaiaError, yaml.YAMLError, RecursionError, ValueError) as error:
        # Not what it says: that may be a line of the file.
        return {"cannot be read": type(error).__name__}
    return read


def _tree_text(tree: object, redactor: Redactor) -> str:
    # In one line each: a secret that is folded would be found by nobody.
    return yaml.safe_dump(
        redactor.clean_tree(tree), allow_unicode=True, sort_keys=False, width=float("inf")
    )


def _check_text(path: Path) -> str:
    try:
        findings: Iterable[object] = check_site(load_site(text_of(path)))
    except TalaiaError as error:
        findings = [error]
    rows = [str(finding) for finding in findings]
    return "\n".join([*(rows or ["right"]), ""])


def _describe_settings(
    sources: BundleSources,
    environments: Iterable[Mapping[str, str]],
    trees: Mapping[Path, object],
    redactor: Redactor,
) -> str:
    rows = []
    for environment in environments:
        shown = {
            name: value
            for name, value in sorted(environment.items())
            if name.startswith(("TALAIA_", "ROS_", "RMW_", "AMENT_", "LC_", "LANG"))
        }
        said = redactor.clean_tree(shown)
        rows.append("variables of a process\n" + _tree_text(said, redactor))
    rows += [f"{path.name}\n" + _tree_text(trees[path], redactor) for path in sources.settings]
    return "\n".join(rows)
