"""``talaia generate``: a folder that runs a site for good, in containers or by systemd.

Long, because each option stands here with what it asks of the others.
"""

from __future__ import annotations

import argparse
import importlib.util
import re
import secrets
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError
from talaia.deploy.options import (
    FEWEST_HUBS,
    MOST_HISTORY_SERVERS,
    MOST_HUBS,
    ROS_DISTROS,
    DatabaseKind,
    DeployOptions,
    FilesChoice,
)
from talaia.hub.files.bucket_address import read_bucket_address
from talaia.hub.files_options import add_files_options, read_files_settings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.deploy.project import File

__all__ = ["main"]

# Files of this folder are never written twice, not even by --force.
_KEPT = "secrets/"
_PIN = re.compile(r"[^@\s]+@sha256:[0-9a-f]{64}\Z")


def main(argv: Sequence[str]) -> int:
    """Write the folder; nothing is written when anything is wrong."""
    options = _parse_options(argv)
    # The whole model, which --help and wrong words do not wait for.
    from talaia.deploy.project import make_deployment
    from talaia.model.checks.site_checks import raise_first
    from talaia.model.yaml_text.load import read_site

    site = raise_first(read_site(options.site))
    for where, path in (("--program", options.program), ("--ros-setup", options.ros_setup)):
        # In a unit there is no folder that a relative path could begin at.
        if path and not path.startswith("/"):
            raise CliError(f"{where}: expected an absolute path, found {path!r}")
    if not 1 <= options.port <= 65535:
        raise CliError(f"--port: expected 1 to 65535, found {options.port}")
    if options.arch == "arm64" and not options.ros_distro and site.ros2 is not None:
        raise CliError(
            "--arch arm64: there are no wheels of ROS 2 for it; add --ros-distro "
            f"({', '.join(ROS_DISTROS)})"
        )
    for wheel in options.wheel:
        if not wheel.is_file():
            raise CliError(f"--wheel {wheel}: there is no such file")
    database = _choose_database(options)
    choice = DeployOptions(
        database=database,
        port=options.port,
        hosts=tuple(options.allow_host),
        version=_version_of(options.wheel),
        program=options.program,
        setup=options.ros_setup,
        ros_distro=options.ros_distro,
        arch=options.arch,
        hubs=options.hubs or 1,
        files=_choose_files(options),
        history_servers=_choose_histories(options),
        shards=options.shards,
    )
    password = _kept_password(options.to, choice) if options.force else ""
    # The text as it is, with its comments: the copy is what a person goes on to edit.
    text = options.site.read_text()
    files = make_deployment(
        site, text, choice, lambda: secrets.token_urlsafe(24), password=password
    )
    files = _pin_images(files, options.pin)
    _write_files(options.to, files, force=options.force)
    _bring_wheels(options.to, options.wheel)
    print(f"{options.to}: {len(files)} files; README.md there says how to start", file=sys.stderr)
    return 0


def _choose_database(options: argparse.Namespace) -> DatabaseKind:
    if options.hubs is None:
        return DatabaseKind(options.database or DatabaseKind.MARIADB)
    if not FEWEST_HUBS <= options.hubs <= MOST_HUBS:
        raise CliError(
            f"--hubs: expected {FEWEST_HUBS} to {MOST_HUBS}, found {options.hubs}; "
            "leave it out for one hub"
        )
    if options.database not in {None, DatabaseKind.POSTGRESQL.value}:
        raise CliError(
            f"--hubs: several hubs are written with PostgreSQL, not {options.database}; "
            "leave --database out"
        )
    if importlib.util.find_spec("cryptography") is None:
        raise CliError(
            "--hubs needs cryptography, which is not installed; pip install 'talaia[hub]'"
        )
    return DatabaseKind.POSTGRESQL


def _choose_histories(options: argparse.Namespace) -> int:
    if options.history_servers is None:
        if options.shards:
            raise CliError(
                "--shards: each is a database of histories; add --hubs 3 --history-servers 2"
            )
        return 0
    if options.hubs is None:
        raise CliError("--history-servers: they are written for several hubs; add --hubs 3")
    if not 1 <= options.history_servers <= MOST_HISTORY_SERVERS:
        raise CliError(
            f"--history-servers: expected 1 to {MOST_HISTORY_SERVERS},"
            f" found {options.history_servers}"
        )
    if options.shards and options.hubs <= options.history_servers:
        fewest = options.history_servers + 1
        raise CliError(
            f"--shards: {options.history_servers} shards and the main one have a lead each, so "
            f"name at least {fewest} hubs, and one more as a spare; found {options.hubs}"
        )
    return int(options.history_servers)


def _choose_files(options: argparse.Namespace) -> FilesChoice | None:
    if not options.files:
        return None
    if options.hubs is None:
        raise CliError("--files: a bucket is written for several hubs; add --hubs 3")
    if options.files_key_file is None:
        raise CliError("--files needs --files-key-file: the key's id and its secret, a line each")
    settings = read_files_settings(options, Path())
    # What a hub would refuse is refused now. The variables of this machine are not the hub's.
    address = read_bucket_address(settings, {})
    if address is None or address.key is None:
        return None
    return FilesChoice(
        url=address.url,
        endpoint=address.endpoint,
        region=options.files_region,
        key="\n".join(filter(None, address.key)) + "\n",
        ca=address.ca,
    )


def _kept_password(folder: Path, choice: DeployOptions) -> str:
    """Give the database's password of a folder that is written anew; empty: it has none.

    Raises:
        CliError: what is kept there does not fit what is to be written.

    """
    from talaia.deploy.history_databases import history_secret_names
    from talaia.deploy.project import BUS_SECRETS

    try:
        url = (folder / "secrets/database_url").read_text()
        password = (folder / "secrets/database_password").read_text()
    except FileNotFoundError:
        url = password = ""
    except (OSError, UnicodeDecodeError) as error:
        raise CliError(f"{folder}/secrets cannot be read: {error}") from error
    kind = choice.database.value
    if url and choice.database is not DatabaseKind.SQLITE and not url.startswith(f"{kind}://"):
        raise CliError(
            f"{folder} was made for {url.partition(':')[0]}, and its secrets are kept; choose "
            f"another folder for {kind}, and move what is stored there"
        )
    histories = [f"secrets/{name}" for name in history_secret_names(choice.history_servers)]
    for together in (BUS_SECRETS, histories):
        there = [name for name in together if (folder / name).exists()]
        if choice.hubs > 1 and there and len(there) < len(together):
            lacking = next(name for name in together if name not in there)
            # A password that a database knows must not be made anew.
            remedy = (
                f"remove {', '.join(there)}"
                if together is BUS_SECRETS
                else "name as many history servers as before, or another folder"
            )
            raise CliError(
                f"{folder} has {there[0]} and no {lacking}, which were made together; {remedy}"
            )
    if choice.history_servers:
        _check_kept_shards(folder, choice)
    return password


def _check_kept_shards(folder: Path, choice: DeployOptions) -> None:
    """See that a kept file of history servers divides the sites as was chosen.

    Raises:
        CliError: it does not; it has passwords, and is not written anew.

    """
    from talaia.deploy.several_hubs import HISTORY_FILE

    for name in (HISTORY_FILE, f"kubernetes_{HISTORY_FILE}"):
        path = folder / "secrets" / name
        if path.exists() and ("\nshards:" in path.read_text()) != choice.shards:
            remedy = "end all hubs, write default: and shards: there, and run this again"
            if not choice.shards:
                remedy = "add --shards, or end all hubs and take the line out"
            said = "no shards" if choice.shards else "shards"
            raise CliError(f"{path} is kept, and has {said}; {remedy}")


def _pin_images(files: dict[str, File], pins: Sequence[str]) -> dict[str, File]:
    from talaia.deploy.project import named_images, pin_images

    # A pin of an image that is not there would be for nothing, and nobody would see it.
    known = named_images(files)
    for pin in pins:
        if not _PIN.match(pin):
            raise CliError(
                f"--pin: expected IMAGE@sha256: and 64 hexadecimal digits, found {pin!r}"
            )
        if pin.partition("@")[0] not in known:
            raise CliError(
                f"--pin {pin.partition('@')[0]}: this deployment has no such image; it has "
                f"{', '.join(known)}"
            )
    return pin_images(files, pins)


def _version_of(given: Sequence[Path]) -> str:
    """Give the version that images install: of the wheel that was given, else our own."""
    found = [wheel.name.split("-")[1] for wheel in given if wheel.name.startswith("talaia-")]
    if found:
        return found[0]
    from talaia import __version__

    return __version__


def _bring_wheels(project: Path, given: Sequence[Path]) -> None:
    """Lay Talaia's own wheels where the images take them from."""
    from talaia.cli.own_wheel import MODELS, pack_own_wheel

    folder = project / "wheels"
    # What a person gives is what they want in the images, whatever runs here.
    for wheel in given:
        shutil.copy(wheel, folder)
    wanted = {"talaia": "."}
    recipes = [(project / f"{image}.Dockerfile").read_text() for image in ("hub", "gateway")]
    if any("objects" in recipe for recipe in recipes):
        wanted[MODELS] = "packages/models"
    missing = []
    for name, where in wanted.items():
        begin = f"{name.replace('-', '_')}-"
        if (
            not any(wheel.name.startswith(begin) for wheel in given)
            and pack_own_wheel(folder, name) is None
            # Of a run before.
            and not any(folder.glob(f"{begin}*.whl"))
        ):
            missing.append(f"    python -m build --wheel --outdir {folder} {where}\n")
    if missing:
        sys.stderr.write(
            f"{folder} needs Talaia's wheels before the images are built: this Talaia runs from a "
            f"checkout, or without what its cameras need; in a checkout, run\n{''.join(missing)}"
        )


def _add_several_hubs(parser: argparse.ArgumentParser) -> None:
    """Add how many hubs there are, and what is divided among them."""
    parser.add_argument(
        "--hubs",
        type=int,
        metavar="N",
        help=f"{FEWEST_HUBS} to {MOST_HUBS} hubs as one, of which each takes over from another: "
        "behind HAProxy, on NATS and PostgreSQL, as a compose project and for Kubernetes (one hub)",
    )
    parser.add_argument(
        "--history-servers",
        type=int,
        metavar="N",
        help="so many databases of PostgreSQL for histories alone, beside that of accounts; "
        "with --hubs (none: all is in one)",
    )
    parser.add_argument(
        "--shards",
        action="store_true",
        help="each database of --history-servers has a lead of its own among the hubs, and sites "
        "are divided among them (one hub leads all sites)",
    )


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia generate",
        description="Write a folder that runs a site for good: a compose project (hub, database, "
        "gateway), systemd units for a robot's own computer, and how to start them.",
    )
    parser.add_argument("site", type=Path, help="site description (YAML)")
    parser.add_argument("--to", type=Path, required=True, metavar="DIR", help="the folder")
    parser.add_argument(
        "--database",
        choices=[database.value for database in DatabaseKind],
        help="where accounts and history are kept (mariadb; of several hubs postgresql)",
    )
    _add_several_hubs(parser)
    add_files_options(parser)
    parser.add_argument("--port", type=int, default=8443, help="of the dashboard (8443)")
    parser.add_argument(
        "--allow-host",
        action="append",
        default=[],
        metavar="NAME",
        help="host name of the dashboard; may be repeated",
    )
    parser.add_argument(
        "--program",
        default="/opt/talaia/bin/talaia",
        metavar="FILE",
        help="talaia on the robot's computer (/opt/talaia/bin/talaia)",
    )
    parser.add_argument(
        "--ros-setup", default="", metavar="FILE", help="setup.bash of the ROS installation there"
    )
    parser.add_argument(
        "--ros-distro",
        choices=ROS_DISTROS,
        default="",
        help="make the gateway's image from this distribution's own (ros:DISTRO), which is there "
        "for arm64, too; without it ROS 2 comes from wheels, for amd64 only",
    )
    parser.add_argument(
        "--arch",
        choices=("amd64", "arm64"),
        default="",
        help="of the gateway's machine (that of whoever builds the image)",
    )
    parser.add_argument(
        "--wheel",
        type=Path,
        nargs="+",
        action="extend",
        default=[],
        metavar="FILE",
        help="Talaia's wheels, to build the images from (this Talaia, packed from where it is "
        "installed)",
    )
    parser.add_argument(
        "--pin",
        action="append",
        default=[],
        metavar="IMAGE@DIGEST",
        help="write an image of others with its digest (postgres:17@sha256:…); may be repeated",
    )
    parser.add_argument(
        "--force", action="store_true", help="overwrite existing files; secrets are kept"
    )
    return parser.parse_args(argv)


def _write_files(folder: Path, files: dict[str, File], *, force: bool) -> None:
    # Looked for before anything is written: a refusal leaves the folder as it was.
    there = [name for name in files if (folder / name).exists()]
    if there and not force:
        raise CliError(f"{folder} holds {there[0]} already; choose another folder, or --force")
    try:
        for name, file in files.items():
            path = folder / name
            if name.startswith(_KEPT) and path.exists():
                # The database knows the password of before; who may read it may have changed.
                path.chmod(file.mode)
                continue
            secret = name.startswith(_KEPT)
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700 if secret else 0o755)
            # The mode before the text, so that a secret is at no moment readable by others.
            path.touch(mode=file.mode)
            path.chmod(file.mode)
            path.write_text(file.text)
    except OSError as error:
        raise CliError(f"{error.filename or folder} cannot be written: {error.strerror}") from error
