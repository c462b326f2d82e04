"""Cross-checks of what outlets feed; part of `check`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.arguments import fields_of
from talaia.model.checks.identifiers import Finding, id_fits
from talaia.model.errors import UnknownWord
from talaia.model.interlocks.outlet_needs import cutting_commands

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.interlocks.outlet import OutletCommand
    from talaia.model.site import Device, Site

__all__ = ["outlet_findings"]


def outlet_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in the outlets of a site's devices."""
    for device_id, device in site.devices.items():
        for name, outlet in device.outlets.items():
            where = f"$.devices.{device_id}.outlets.{name}"
            yield from id_fits(where, name)
            if not outlet.feeds:
                yield Finding(
                    f"{where}.feeds", "it feeds nothing", "name a device, or leave it out"
                )
            for index, fed in enumerate(outlet.feeds):
                yield from _check_fed(site, f"{where}.feeds[{index}]", fed)
            for index, cut in enumerate(outlet.cut_by):
                yield from _cut_by(device, f"{where}.cut_by[{index}]", cut)
            if not cutting_commands(device, name):
                problem = f"no command of {device_id} is known to cut its power"
                remedy = f"write cut_by: [{{command: …}}], or name it as its command: {name}"
                yield Finding(f"{where}.cut_by", problem, remedy)


def _check_fed(site: Site, where: str, fed: str) -> Iterator[Finding]:
    if fed not in site.devices:
        word = UnknownWord(where, "device", fed, list(site.devices))
        yield Finding(word.where, word.problem, word.remedy)


def _cut_by(device: Device, where: str, cut: OutletCommand) -> Iterator[Finding]:
    command = device.commands.get(cut.command)
    if command is None:
        word = UnknownWord(f"{where}.command", "command", cut.command, list(device.commands))
        yield Finding(word.where, word.problem, word.remedy)
        return
    for name in cut.args:
        if name not in command.arguments:
            word = UnknownWord(f"{where}.args.{name}", "argument", name, list(command.arguments))
            yield Finding(word.where, word.problem, word.remedy)
            return
    # Those that stand in no rule may be anything; what stands here must be what a person could ask.
    only = {name: argument for name, argument in command.arguments.items() if name in cut.args}
    fields = fields_of(type(command)(name="", target="", arguments=only), cut.args)
    if isinstance(fields, str):
        yield Finding(f"{where}.args", fields)
