"""``talaia demo time-lapse``: an observatory that lives through its nights at high speed."""

from __future__ import annotations

import argparse
import asyncio
import logging
import signal
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.demo.time_lapse.lapse_gateway import LapseGateway
from talaia.cli.demo.time_lapse.lapse_thread import LapseSettings
from talaia.gateway.key_file import read_key_file
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.model.yaml_text.load import read_site

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Run until SIGINT or SIGTERM."""
    parser = argparse.ArgumentParser(
        "talaia demo time-lapse",
        description="Live through the nights of a simulated observatory, many times as fast as"
        " they go by; each begins when somebody arms it. Started by talaia demo.",
    )
    parser.add_argument("site", type=Path, help="its description (YAML)")
    parser.add_argument("--hub", required=True, metavar="URL", help="ws://localhost:port")
    parser.add_argument("--key-file", required=True, type=Path, metavar="FILE")
    parser.add_argument("--data", required=True, type=Path, metavar="DIR")
    parser.add_argument(
        "--speed", type=float, default=150.0, help="of an armed night (default 150)"
    )
    parser.add_argument("--hours", type=float, default=0.0, help="only the last of each night")
    parser.add_argument("--seed", type=int, default=1, help="of the weather (default: 1)")
    options = parser.parse_args(argv)
    logging.basicConfig(
        level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s"
    )
    # A line for each message would be most of the log.
    logging.getLogger("websockets").setLevel(logging.WARNING)
    asyncio.run(_serve(options))
    return 0


async def _serve(options: argparse.Namespace) -> None:
    settings = GatewaySettings(
        hub=HubAddress.from_text(options.hub, allow_plain=True),
        key=read_key_file(options.key_file).key,
        data=options.data,
        folder=options.site.parent,
    )
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    gateway = LapseGateway(
        site=read_site(options.site),
        settings=settings,
        lapse=LapseSettings(options.speed, options.hours, options.seed),
    )
    await gateway.run(ended)
