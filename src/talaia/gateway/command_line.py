"""The gateway's command line: words to settings."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.errors import SettingsError
from talaia.gateway.key_file import read_key_file
from talaia.gateway.notices.settings import read_notice_settings
from talaia.gateway.settings import GatewaySettings, HubAddress, LegacySettings, UpdateSettings
from talaia.log_setup import add_log_options
from talaia.objects.errors import DetectorError
from talaia.objects.providers import parse_provider
from talaia.program_options import parse_options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.gateway.key_file import KeyFile
    from talaia.model.site import Site
    from talaia.program_options import OptionSource

__all__ = ["parse_arguments", "settings_of"]


class _Parser(argparse.ArgumentParser):
    # One line and no usage: under a service manager it stands in a log.
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"talaia gateway: {message}\n")


def parse_arguments(argv: Sequence[str]) -> tuple[argparse.Namespace, list[OptionSource]]:
    """Read words, variables and settings file; a mistake ends the process with 2 and one line.

    Returns:
        The options, and where each comes from.

    Raises:
        OptionRefused: the settings file cannot be read, or does not fit.

    """
    parser = _Parser(prog="talaia gateway", description="Run the gateway beside a robot.")
    parser.add_argument("site", type=Path, help="site description (YAML)")
    parser.add_argument(
        "--hub",
        metavar="URL",
        help="wss://host:port; not needed with a key file of enrol; of several hubs that are one,"
        " all addresses with commas between",
    )
    parser.add_argument(
        "--key-file", required=True, type=Path, metavar="FILE", help="made by talaia gateway enrol"
    )
    trust = parser.add_mutually_exclusive_group()
    trust.add_argument("--fingerprint", default="", metavar="HEX", help="SHA-256 of the hub's cert")
    trust.add_argument("--ca", type=Path, metavar="FILE", help="certificate authorities (PEM)")
    parser.add_argument("--allow-plain", action="store_true", help="permit ws:// on loopback")
    parser.add_argument("--data", type=Path, metavar="DIR", help="what must survive a restart")
    parser.add_argument(
        "--spool-mb",
        type=_read_positive,
        default=1024,
        metavar="N",
        help="most disk for samples that wait for the hub (MB; the oldest give way)",
    )
    parser.add_argument(
        "--spool-days",
        type=_read_positive,
        default=14,
        metavar="N",
        help="longest that samples wait for the hub",
    )
    parser.add_argument("--ros-domain", type=int, metavar="N", help="overrides the description's")
    parser.add_argument(
        "--accept-changes",
        type=AcceptedChanges,
        choices=list(AcceptedChanges),
        default=AcceptedChanges.NO,
        metavar="{no,readings,all}",
        help="which changes of the description people with the right may send through the hub: "
        "none, of what is read and shown, or also of commands, driving and interlocks "
        "(default: no)",
    )
    parser.add_argument(
        "--notices",
        type=Path,
        metavar="FILE",
        help="ways to people while the hub is away (TOML); try them with talaia gateway"
        " test-notice FILE",
    )
    parser.add_argument(
        "--detector-provider",
        type=_read_provider,
        default="cpu",
        metavar="NAME",
        help="what detectors of objects and faces run on: cpu, cuda, tensorrt, openvino, coreml, "
        "..., or NAME=LIBRARY of a plug-in; talaia doctor tries what is here (default: cpu)",
    )
    _add_asset_options(parser)
    _add_update_options(parser)
    _add_classic_options(parser)
    parser.add_argument("--verbose", action="store_true", help="the same as --log-level debug")
    add_log_options(parser)
    return parse_options(parser, argv, "TALAIA_GATEWAY_")


def _add_classic_options(parser: argparse.ArgumentParser) -> None:
    classic = parser.add_argument_group(
        "door for clients of the founding observatory (WebSocket messages over TLS)"
    )
    classic.add_argument(
        "--classic-port", type=_read_port, metavar="N", help="open it; 0 takes any"
    )
    classic.add_argument(
        "--classic-host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="listen on this address (default: this machine only)",
    )
    classic.add_argument("--classic-cert", type=Path, metavar="FILE", help="certificate (PEM)")
    classic.add_argument("--classic-key", type=Path, metavar="FILE", help="its key (PEM)")
    classic.add_argument(
        "--classic-token-file", type=Path, metavar="FILE", help="holds the token clients must give"
    )


def _add_asset_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--no-meshes",
        action="store_true",
        help="hand no files of ROS packages to the hub; otherwise those that the robot's"
        " description names",
    )
    parser.add_argument(
        "--meshes-from",
        type=Path,
        metavar="DIR",
        help="such files may also lie below this folder, where links of a workspace lead",
    )


def _add_update_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--releases", type=Path, metavar="DIR", help="folder of releases; talaia update run sets it"
    )
    parser.add_argument(
        "--update-rest",
        type=_read_positive,
        default=30.0,
        metavar="S",
        help="the gateway ends for a release that waits when nothing has moved for so long (30)",
    )


def _read_port(text: str) -> int:
    # ASCII digits only: `int` takes those of other scripts as well.
    if not text.isascii() or not text.isdigit() or not 0 <= int(text) <= 65_535:
        raise argparse.ArgumentTypeError(f"{text} is not a port from 0 to 65535")
    return int(text)


def _read_positive(text: str) -> float:
    number = float(text)
    # Not `> 0` alone: NaN and infinity are turned away by this, too.
    if not 0 < number < 1e9:
        raise argparse.ArgumentTypeError(f"{text} is not a number over 0")
    return number


def _read_provider(text: str) -> str:
    try:
        parse_provider(text)
    except DetectorError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def settings_of(arguments: argparse.Namespace, site: Site) -> GatewaySettings:
    """Make settings of the words.

    Raises:
        SettingsError: a key file that holds no key, an address that is none.

    """
    kept = read_key_file(arguments.key_file)
    if kept.site and kept.site != site.site:
        raise SettingsError(
            f"--key-file {arguments.key_file} is for the site {kept.site!r}, and the description "
            f"is of {site.site!r}; give the key file of this site, or enrol for it"
        )
    if not arguments.hub and not kept.hub:
        raise SettingsError(
            f"--key-file {arguments.key_file} does not say where the hub is; give --hub"
        )
    # Where state belongs that must survive a restart (XDG Base Directory).
    state = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return GatewaySettings(
        hub=_hub_address(arguments, kept),
        key=kept.key,
        data=arguments.data or Path(state) / "talaia" / "gateway" / site.site,
        # Paths in a description begin where it stands, wherever the gateway is started.
        folder=arguments.site.parent,
        domain=arguments.ros_domain,
        detector_provider=arguments.detector_provider,
        spool_bytes=round(arguments.spool_mb * 1024 * 1024),
        spool_age_s=arguments.spool_days * 86400.0,
        door=_legacy_settings(arguments),
        accepts=arguments.accept_changes,
        updates=(
            UpdateSettings(arguments.releases, rest_s=arguments.update_rest)
            if arguments.releases
            else None
        ),
        meshes=not arguments.no_meshes,
        meshes_from=arguments.meshes_from,
        notices=read_notice_settings(arguments.notices) if arguments.notices else None,
    )


def _legacy_settings(arguments: argparse.Namespace) -> LegacySettings | None:
    if arguments.classic_port is None:
        return None
    if (arguments.classic_cert is None) != (arguments.classic_key is None):
        raise SettingsError("--classic-cert and --classic-key belong together; give both or none")
    return LegacySettings(
        arguments.classic_port,
        arguments.classic_host,
        arguments.classic_cert,
        arguments.classic_key,
        arguments.classic_token_file,
    )


def _hub_address(arguments: argparse.Namespace, kept: KeyFile) -> HubAddress:
    """Take the address and the trust of the words, else those of the key file."""
    # A fingerprint that is given stands for all trust: the file's authority is not asked as well.
    ca = arguments.ca or (Path(kept.ca) if kept.ca and not arguments.fingerprint else None)
    return HubAddress.from_text(
        arguments.hub or kept.hub,
        fingerprint=arguments.fingerprint or ("" if arguments.ca else kept.fingerprint),
        ca=ca,
        # Whoever enrolled in clear text (on loopback) has asked for it then.
        allow_plain=arguments.allow_plain or not arguments.hub,
    )
