"""Which command of a device opens it, parks it, points it, where nobody says it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.connections.onvif import ONVIF_COMMANDS
from talaia.model.discovery.role_words import argument_with, has_word, is_number
from talaia.model.roles import COMMAND_FITS, CommandRole, SignalRole
from talaia.model.site import ArgumentType, CommandKind, DeviceKind

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.model.site import Command, Device

__all__ = ["CommandRoles"]

# What an ONVIF camera is asked.
_OF_ONVIF = {
    "GotoPreset": CommandRole.CAMERA_GOTO_PRESET,
    "SetPreset": CommandRole.CAMERA_SET_PRESET,
    "RemovePreset": CommandRole.CAMERA_REMOVE_PRESET,
    "GotoHomePosition": CommandRole.CAMERA_HOME,
}
_STOPS = ("stop", "abort", "halt")


class CommandRoles:
    """The roles of a device's commands, as they are found: those that are said come first.

    Attributes:
        roles: by the command's id.

    """

    def __init__(self, device: Device, signals: Mapping[str, SignalRole]) -> None:
        """Begin with what the description says; outlets are known by their signals' roles."""
        self._device = device
        self._signals = signals
        self.roles: dict[str, CommandRole] = {
            name: command.role
            for name, command in device.commands.items()
            if command.role not in {CommandRole.AUTO, CommandRole.NONE}
        }

    def propose_roles(self) -> None:
        """Find the others, by the kind of the device."""
        match self._device.kind:
            case DeviceKind.DOME:
                self._propose_dome()
            case DeviceKind.TELESCOPE:
                self._propose_telescope()
            case DeviceKind.CAMERA:
                self._propose_camera()
            case DeviceKind.POWER:
                self._propose_power()
            case DeviceKind.OTHER:
                # A robot's filters are of another kind.
                if has_word("", self._device.name, "filter", "filterwheel"):
                    self._propose_filter()
            case DeviceKind.WEATHER | DeviceKind.VEHICLE:
                pass
        self._propose_focuser()  # a camera or a telescope may carry one

    # ── what is there to choose from ──

    def _free_commands(self) -> dict[str, Command]:
        # Asked anew for each role: every role that is given takes a command away.
        return {
            name: command
            for name, command in self._device.commands.items()
            # ``none`` was said on purpose, and stays.
            if command.role is CommandRole.AUTO and name not in self.roles
        }

    def _find_plain(self, *words: str) -> str | None:
        """Name a command without arguments whose id, or else name, has one of these words."""
        plain = {
            name: found for name, found in self._free_commands().items() if not found.arguments
        }
        by_id = next((name for name in plain if name in words), None)
        return by_id or next(
            (
                name
                for name, found in plain.items()
                if has_word(name, found.name, *words)
                # A flap or a cover opens beside the roof, not as the roof.
                and not has_word(name, found.name, "flap", "cover")
            ),
            None,
        )

    def _find_switch(self, *words: str) -> str | None:
        """Name a command with one boolean."""
        found = {
            name: command
            for name, command in self._free_commands().items()
            if [argument.type for argument in command.arguments.values()] == [ArgumentType.BOOLEAN]
        }
        by_id = next((name for name in found if name in words), None)
        return by_id or next(
            (name for name, command in found.items() if has_word(name, command.name, *words)), None
        )

    def _with_one(self, unit: str) -> list[str]:
        """Name the commands that ask for one number in this unit."""
        return [
            name
            for name, command in self._free_commands().items()
            if [(argument.unit, is_number(argument)) for argument in command.arguments.values()]
            == [(unit, True)]
        ]

    def _assign_role(self, role: CommandRole, name: str | None) -> None:
        if name is None or name in self.roles:
            return
        # Of a role that stands once the first that is found keeps it.
        if COMMAND_FITS[role].many or role not in self.roles.values():
            self.roles[name] = role

    def _assign_plain(self, roles: Iterable[tuple[CommandRole, tuple[str, ...]]]) -> None:
        for role, words in roles:
            self._assign_role(role, self._find_plain(*words))

    # ── kind by kind ──

    def _propose_dome(self) -> None:
        self._assign_plain(
            (
                (CommandRole.DOME_OPEN, ("open",)),
                (CommandRole.DOME_CLOSE, ("close", "shut")),
                (CommandRole.DOME_STOP, _STOPS),
                (CommandRole.DOME_PARK, ("park", "home")),
                (CommandRole.DOME_UNPARK, ("unpark",)),
            )
        )
        self._assign_role(CommandRole.DOME_GOTO, next(iter(self._with_one("°")), None))

    def _propose_telescope(self) -> None:
        self._assign_role(CommandRole.TELESCOPE_GOTO, self._find_slew())
        track = self._find_switch("track", "tracking")
        if track is not None:
            self._assign_role(CommandRole.TELESCOPE_TRACK, track)
        else:
            self._assign_plain(
                (
                    (CommandRole.TELESCOPE_TRACK, ("track",)),
                    (CommandRole.TELESCOPE_UNTRACK, ("untrack",)),
                )
            )
        self._assign_plain(
            (
                (CommandRole.TELESCOPE_UNPARK, ("unpark",)),
                (CommandRole.TELESCOPE_PARK, ("park",)),
                (CommandRole.TELESCOPE_STOP, _STOPS),
            )
        )

    def _find_slew(self) -> str | None:
        """Name what points it: what `pointing` says, or else asks for a place, and is no sync."""
        free, pointing = self._free_commands(), self._device.pointing
        for name, said in pointing.commands.items() if pointing is not None else ():
            if name in free and said.ra and said.dec:
                return name
        for name, command in free.items():
            # Not altitude and azimuth: the role is for right ascension and declination.
            asks = (
                argument_with(command, "ra", "right"),
                argument_with(command, "dec", "declination"),
            )
            if all(asks) and not has_word(name, command.name, "sync"):
                return name
        return None

    def _propose_camera(self) -> None:
        for name, command in self._free_commands().items():
            role = _OF_ONVIF.get(command.target) if command.kind is CommandKind.ONVIF else None
            # One whose preset is fixed is a button of its own.
            if role is not None and (command.arguments or not ONVIF_COMMANDS[command.target]):
                self._assign_role(role, name)
        for name, command in self._free_commands().items():
            if any(
                argument.unit == "s" and argument.type is not ArgumentType.TEXT
                for argument in command.arguments.values()
            ):
                self._assign_role(CommandRole.CAMERA_EXPOSE, name)
        for name in self._with_one("°C"):
            self._assign_role(CommandRole.CAMERA_COOL, name)
        self._assign_role(CommandRole.CAMERA_ABORT, self._find_plain("abort", "stop"))
        self._assign_role(CommandRole.CAMERA_BINNING, self._find_setting("binning"))
        self._assign_role(CommandRole.CAMERA_GAIN, self._find_setting("gain"))
        self._propose_filter()
        cooler = self._find_switch("cooler", "cooling")
        if cooler is not None:
            self._assign_role(CommandRole.CAMERA_COOLER, cooler)
        else:
            self._assign_role(CommandRole.CAMERA_COOLER_ON, self._find_plain("cooler_on"))
            self._assign_role(CommandRole.CAMERA_COOLER_OFF, self._find_plain("cooler_off"))

    def _propose_filter(self) -> None:
        self._assign_role(
            CommandRole.CAMERA_FILTER, self._find_setting("filter") or self._find_named_filter()
        )

    def _find_named_filter(self) -> str | None:
        """Name a command that asks for a filter's name."""
        return next(
            (
                name
                for name, command in self._free_commands().items()
                if has_word(name, command.name, "filter")
                and [one.type for one in command.arguments.values()] == [ArgumentType.TEXT]
            ),
            None,
        )

    def _find_setting(self, word: str) -> str | None:
        """Name a command that asks for numbers only, and has this word."""
        return next(
            (
                name
                for name, command in self._free_commands().items()
                if has_word(name, command.name, word)
                and command.arguments
                and all(is_number(argument) for argument in command.arguments.values())
                and (word == "binning" or len(command.arguments) == 1)
            ),
            None,
        )

    def _propose_focuser(self) -> None:
        """Find what moves a focuser: of a device of that name, or by words of its own."""
        own = has_word("", self._device.name, "focuser", "focus")
        for role, words in (
            (CommandRole.FOCUSER_IN, ("focus_in",)),
            (CommandRole.FOCUSER_OUT, ("focus_out",)),
            (CommandRole.FOCUSER_GOTO, ("focus", "goto") if own else ("focus",)),
            (CommandRole.FOCUSER_MOVE, ("move",) if own else ()),
        ):
            numbers = (name for name in self._with_one("") if name in words)
            self._assign_role(role, next(numbers, None))
        stops = ("stop_focus", *_STOPS) if own else ("stop_focus",)
        self._assign_role(
            CommandRole.FOCUSER_STOP,
            next((name for name in stops if name == self._find_plain(name)), None),
        )

    def _propose_power(self) -> None:
        free = self._free_commands()
        for outlet, role in self._signals.items():
            if role is not SignalRole.POWER_OUTLET:
                continue
            # A switch with the outlet's own id, or else two commands, ``_on`` and ``_off``.
            if outlet in free and self._find_switch(outlet) == outlet:
                self._assign_role(CommandRole.POWER_SWITCH, outlet)
                continue
            for ending, switches in (("on", CommandRole.POWER_ON), ("off", CommandRole.POWER_OFF)):
                name = f"{outlet}_{ending}"
                if name in free and not free[name].arguments:
                    self._assign_role(switches, name)
