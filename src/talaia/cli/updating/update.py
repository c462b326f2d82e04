"""``talaia update``: its subcommands."""

from __future__ import annotations

import argparse
import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["main"]

# A gateway dials at once, and again after some seconds; a robot's radio may take longer (s).
_LINK_S = 180.0


def main(argv: Sequence[str]) -> int:
    """Do one of them; ``run`` ends with the gateway's exit code."""
    words = list(argv)
    gateway_words: list[str] = []
    # What is behind -- is the gateway's.
    if words[:1] == ["run"] and "--" in words:
        at = words.index("--")
        words, gateway_words = words[:at], words[at + 1 :]
    options = _make_parser().parse_args(words)
    if options.action == "run":
        options.words = gateway_words
    act: Callable[[argparse.Namespace], int] = options.act
    return act(options)


def _make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "talaia update",
        description="Update a gateway by signed releases: installed beside the one that runs, "
        "tried once the robot is at rest, and left again by itself if the link to the hub does not "
        "return.",
    )
    actions = parser.add_subparsers(dest="action", required=True)
    key = actions.add_parser("key", help="make a publisher's key, and print its public half")
    key.add_argument("file", type=Path, help="the private key; must not be there yet")
    key.set_defaults(act=_make_key)
    sign = actions.add_parser("sign", help="write a signed release of wheels")
    sign.add_argument("release", type=Path, help="file to write; must not be there yet")
    sign.add_argument("wheels", type=Path, nargs="+", help="Talaia's wheel and all that it needs")
    sign.add_argument("--key", type=Path, required=True, help="the publisher's private key")
    sign.add_argument("--version", help="refuse other versions of Talaia's wheel than this (any)")
    sign.add_argument("--site", default="", help="only for this site's gateway (all)")
    sign.set_defaults(act=_sign_wheels)
    for name, said in (
        ("setup", "install the first release into a new folder"),
        ("install", "install a release; the gateway changes to it when it is at rest"),
    ):
        install = actions.add_parser(name, help=said)
        _add_root(install)
        install.add_argument("release", type=Path, help="a signed release")
        install.add_argument("--site", required=True, help="the site of this gateway")
        install.add_argument(
            "--publisher",
            type=Path,
            required=True,
            help="file with the public keys that are trusted, one a line",
        )
        install.add_argument(
            "--system-packages",
            action="store_true",
            help="see the system's Python packages, as for ROS from apt",
        )
        install.add_argument(
            "--from-hub",
            action="store_true",
            help="take later releases from the hub, too, if one of these keys has signed them",
        )
        if name == "install":
            install.add_argument(
                "--allow-downgrade", action="store_true", help="take an older release, too"
            )
        install.set_defaults(act=partial(_install, first=name == "setup"))
    run = actions.add_parser("run", help="start the gateway; its words follow behind --")
    _add_root(run)
    run.add_argument(
        "--link-within",
        type=float,
        default=_LINK_S,
        metavar="S",
        help=f"a release on trial has its link by then, or is left (s; {_LINK_S:g})",
    )
    run.set_defaults(act=_run_gateway)
    status = actions.add_parser("status", help="say which release runs, and what became of others")
    _add_root(status)
    status.set_defaults(act=_print_status)
    return parser


def _add_root(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--root", type=Path, required=True, metavar="FOLDER", help="where the releases are"
    )


def _make_key(options: argparse.Namespace) -> int:
    from cryptography.hazmat.primitives import serialization
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

    key = Ed25519PrivateKey.generate()
    text = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    try:
        number = os.open(options.file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(number, "wb") as file:
            file.write(text)
    except OSError as error:
        raise CliError(f"{options.file} cannot be written: {error.strerror}") from error
    print(key.public_key().public_bytes_raw().hex())
    return 0


def _sign_wheels(options: argparse.Namespace) -> int:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    from talaia.updates.signed_release import sign_release, version_of_wheels

    # Robots go by what is signed, people by what the program says of itself: both are one.
    version = version_of_wheels(options.wheels)
    if options.version not in (None, version):
        raise CliError(f"the wheel of Talaia is {version}, not {options.version} (--version)")
    try:
        key = load_pem_private_key(options.key.read_bytes(), None)
    except (OSError, ValueError, TypeError) as error:
        raise CliError(f"{options.key} cannot be read: {error}") from error
    if not isinstance(key, Ed25519PrivateKey):
        raise CliError(f"{options.key} is no ed25519 key; make one with: talaia update key")
    sign_release(options.wheels, options.release, key, version=version, site=options.site)
    print(f"signed: {options.release} ({version})")
    return 0


def _install(options: argparse.Namespace, *, first: bool) -> int:
    from talaia.updates.environment_builder import build_environment
    from talaia.updates.hub_source import HubSource, write_hub_source
    from talaia.updates.signed_release import open_release, public_key_of
    from talaia.updates.slot_folder import SlotFolder

    try:
        lines = options.publisher.read_text(encoding="utf-8").split()
    except (OSError, UnicodeDecodeError) as error:
        raise CliError(f"{options.publisher} cannot be read: {error}") from error
    release = open_release(options.release, [public_key_of(line) for line in lines], options.site)
    root = options.root.absolute()
    folder = SlotFolder(root)
    build = partial(build_environment, system_packages=options.system_packages)
    version = release.manifest.version
    if first:
        folder.set_up(release, build)
        print(f"installed: {version}")
    else:
        folder.install_release(release, build, downgrade=options.allow_downgrade)
        print(f"installed: {version}; the gateway changes to it when it is at rest")
    if options.from_hub:
        shared = options.system_packages
        write_hub_source(root, HubSource(publishers=lines, system_packages=shared))
    return 0


def _run_gateway(options: argparse.Namespace) -> int:
    from talaia.updates.release_runner import run_release

    return run_release(options.root.absolute(), options.words, options.link_within)


def _print_status(options: argparse.Namespace) -> int:
    from talaia.updates.slot_folder import SlotFolder

    state = SlotFolder(options.root).read_state()
    print(f"current: {state.current}")
    if state.previous:
        print(f"before:  {state.previous}")
    if state.candidate:
        print(f"next:    {state.candidate} ({state.phase})")
    for version, why in state.failed.items():
        print(f"left:    {version}: {why}")
    return 0
