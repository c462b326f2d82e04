"""What ``talaia up`` does: starts hub and gateway of one site, and greets."""

from __future__ import annotations

import asyncio
import re
import time
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.child_processes import ChildProcess, run_together, start_talaia
from talaia.cli.errors import CliError
from talaia.cli.local_machine import data_folder, free_port, has_screen, open_page
from talaia.gateway.errors import SettingsError
from talaia.hub.settings import Settings, is_loopback
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import read_site

if TYPE_CHECKING:
    import argparse
    from pathlib import Path

    from talaia.model.site import Site

__all__ = ["run_site"]

# What is read from the hub's output; `run` in the hub writes these lines.
_FINGERPRINT = re.compile(r"certificate: ([0-9A-Fa-f:]+)")
_SETUP = re.compile(r"https?://\S+/setup#\S+")
_ADDRESS = re.compile(r"ready: (https?://\S+)")
# For each of hub and link; a hub that brings an old database up to date takes its time (s).
READY_S = 60.0


class _Up(NamedTuple):
    """What is running: where, and where the first admin is made, if nobody is there yet."""

    # Of the dashboard, as the hub said it.
    address: str
    # With the code for the first admin's account; empty when there is one.
    setup: str


def run_site(options: argparse.Namespace) -> int:
    """Run until Ctrl-C; what was stored stays for the next time."""
    began = time.monotonic()
    site = raise_first(read_site(options.site))
    data = options.data or data_folder(site.site)
    try:
        # Readable by its owner only: accounts, keys and recordings are in it.
        data.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        raise CliError(
            f"the data folder {data} cannot be made: {error.strerror}; choose another with --data"
        ) from error
    asyncio.run(
        run_together(lambda parts: _start_and_greet(options, site, data, parts, began=began))
    )
    return 0


async def _start_and_greet(
    options: argparse.Namespace, site: Site, data: Path, parts: list[ChildProcess], *, began: float
) -> None:
    up = await _start_parts(options, site, data, parts)
    _print_greeting(up, site, data, time.monotonic() - began)
    if not options.no_browser and has_screen():
        await asyncio.to_thread(open_page, up.setup or up.address)


async def _start_parts(
    options: argparse.Namespace, site: Site, data: Path, parts: list[ChildProcess]
) -> _Up:
    # Without TLS only where no other machine can listen.
    plain = is_loopback(options.host)
    # Chosen here, for hub and gateway are told the same one.
    port = free_port(options.port, options.host)
    settings = Settings(
        data=data, host=options.host, port=port, plain=plain, database_url=Settings.url_from()
    )
    # Straight into the database: at the first start nobody has an account to enrol a gateway with.
    key = await _key_file(settings, site.site, data / "gateway.key")
    hub = ["hub", "--data", str(data), "--host", options.host, "--port", str(port)]
    parts.append(
        await start_talaia("hub", [*hub, *(["--plain"] if plain else [])], data / "hub.log")
    )
    address = _find_line(_ADDRESS, await parts[0].wait_line("ready: ", READY_S))
    # "All addresses" is none that one can connect to.
    inside = "127.0.0.1" if options.host in ("0.0.0.0", "::") else options.host  # noqa: S104
    # An IPv6 address needs brackets in a URL (RFC 3986).
    shown_host = f"[{inside}]" if ":" in inside else inside
    gateway = [
        "gateway",
        str(options.site),
        "--key-file",
        str(key),
        "--data",
        str(data / "gateway"),
        "--hub",
        f"{'ws' if plain else 'wss'}://{shown_host}:{port}",
        "--accept-changes",
        options.accept_changes,
    ]
    if plain:
        # Said on purpose: a gateway does not speak without TLS by itself.
        gateway.append("--allow-plain")
    else:
        shown = await parts[0].wait_line("certificate: ", READY_S)
        # The hub's certificate is its own; no authority signs for it, so it is known by its hash.
        gateway += ["--fingerprint", _find_line(_FINGERPRINT, shown)]
    parts.append(await start_talaia("gateway", gateway, data / "gateway.log"))
    await parts[1].wait_line("linked to", READY_S)
    setup = next((found[0] for line in parts[0].last if (found := _SETUP.search(line))), "")
    return _Up(address, setup)


async def _key_file(settings: Settings, site: str, path: Path) -> Path:
    """See that the gateway has a key, the same one at every start: it stays the same gateway."""
    from talaia.cli.keys import is_good, make_key
    from talaia.gateway.key_file import KeyFile

    try:
        good = await is_good(settings, path, site)
    except SettingsError:
        # Cut short by a full disk or a power cut; the folder is ours.
        await asyncio.to_thread(path.unlink)
        good = False
    if not good:
        await make_key(settings, path, KeyFile(key="", site=site))
    return path


def _find_line(pattern: re.Pattern[str], line: str) -> str:
    match = pattern.search(line)
    if match is None:
        raise CliError(f"unexpected output of the hub: {line}")
    return match[1]


def _print_greeting(up: _Up, site: Site, data: Path, took: float) -> None:
    from talaia.model.interlocks.unguarded import unguarded_notice

    print(f"\n  {site.name} is up ({took:.1f} s):  {up.address}\n")
    if up.setup:
        print(f"  Nobody has an account yet. Make the first admin's here:\n    {up.setup}\n")
    if notice := unguarded_notice(site):
        print(f"  note: {notice}\n")
    print(f"  data and logs: {data}\n  Ctrl-C stops everything; stored data is kept.", flush=True)
