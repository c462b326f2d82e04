"""The gateway as a process: read the description, run gateways until told to stop."""

from __future__ import annotations

import asyncio
import faulthandler
import logging
import signal
import sys
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.errors import TalaiaError
from talaia.gateway.app import Gateway
from talaia.gateway.command_line import settings_of
from talaia.gateway.reload.description_file import DescriptionFile
from talaia.gateway.reload.discovered_devices import with_kept
from talaia.log_setup import add_log_field, set_up_log
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import site_in
from talaia.process_tuning.allocator import keep_little_free_memory
from talaia.process_tuning.event_loop import new_event_loop
from talaia.process_tuning.time_slice import shorten_time_slice
from talaia.resource_usage import report_usage_on_signal
from talaia.service_manager import own_service_manager

if TYPE_CHECKING:
    import argparse

    from talaia.gateway.settings import GatewaySettings
    from talaia.model.site import Site

__all__ = ["run_gateway", "serve_gateway"]


def run_gateway(arguments: argparse.Namespace) -> int:
    """Run a gateway until SIGINT or SIGTERM; 0 after a clean end, 2 if it cannot start."""
    # Says where each thread stood when a service manager ends a process that stands still.
    # The process's own, which has a descriptor; whoever calls this may have put another in place.
    if sys.__stderr__ is not None:
        faulthandler.enable(sys.__stderr__)
    level = "debug" if arguments.verbose else arguments.log_level
    set_up_log(level, arguments.log_format, program="gateway")
    # It logs each frame, which at DEBUG would be everything a robot says.
    logging.getLogger("websockets").setLevel(logging.WARNING)
    try:
        # A thread that decodes may hold the interpreter this long before a driving frame gets it;
        # Python's own 5 ms would be the largest part of the frame's way to the robot.
        sys.setswitchinterval(0.0005)
        # The event loop is in this thread: each driving frame wakes it.
        shorten_time_slice()
        # Before any thread is started: the allocator makes its arenas with them.
        keep_little_free_memory()
        copy = DescriptionFile(arguments.site)
        site = raise_first(site_in(copy.text, arguments.site))
        add_log_field("TALAIA_SITE", site.site)
        settings = settings_of(arguments, site)
        with asyncio.Runner(loop_factory=new_event_loop) as runner:
            runner.run(_serve_until_signal(site, settings, copy))
    except TalaiaError as error:
        sys.stderr.write(f"talaia gateway: {error}\n")
        return 2
    return 0


async def _serve_until_signal(site: Site, settings: GatewaySettings, copy: DescriptionFile) -> None:
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    # Both end it well: the watchdog is told goodbye, and leaves the roof alone.
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    report_usage_on_signal(loop)
    await serve_gateway(site, settings, ended, copy)


async def serve_gateway(
    site: Site, settings: GatewaySettings, ended: asyncio.Event, copy: DescriptionFile | None = None
) -> None:
    """Run gateways until ``ended``: one after the other as devices are found.

    With a ``copy`` the description follows its file; see `DescriptionFile`.
    """
    if copy is not None:
        # With nothing found yet: what earlier runs found is joined below.
        copy.accept_text(site, copy.text)
    # One for all gateways of this process.
    manager = own_service_manager()
    following: Site | None = with_kept(settings.data, site)
    while following is not None and not ended.is_set():
        gateway = Gateway(
            site=following, settings=settings, clock=SystemClock(), file=copy, manager=manager
        )
        await gateway.run(ended)
        following = gateway.redescribed
    # Only at the very end: a gateway that begins anew is no stop of the service.
    manager.report_stopping()
    manager.close()
