"""Names of topics under one prefix, and which of them ask for something.

Names of sites, devices and signals are words of small letters, so what begins with ``$`` is ours.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["CommandTopic", "TopicTree"]

_STATE, _ASK, _ANSWER, _STOP = "$state", "$do", "$done", "$stop"


class CommandTopic(NamedTuple):
    """What a topic asks for; without a ``command`` it is STOP (software)."""

    site: str
    device: str
    command: str


class TopicTree(NamedTuple):
    """All names under a prefix of one or more levels.

    Attributes:
        prefix: of every topic.
        suffix: of one of several hubs that each have some of the sites; empty: of the one that
            has the rest.

    """

    prefix: str
    suffix: str = ""

    @property
    def hub_state(self) -> str:
        """Whether the hub is there that publishes the sites."""
        return f"{self.prefix}/{_STATE}{self.suffix}"

    def is_about(self, topic: str, site: str) -> bool:
        """Tell whether a topic is one of a site's."""
        return topic.startswith(f"{self.prefix}/{site}/")

    def site_state(self, site: str) -> str:
        """Name where it stands whether a site's gateway is connected."""
        return f"{self.prefix}/{site}/{_STATE}"

    def device_state(self, site: str, device: str) -> str:
        """Name where it stands whether a device is reached."""
        return f"{self.prefix}/{site}/{device}/{_STATE}"

    def channel_value(self, site: str, address: str) -> str:
        """Name where a channel's newest value stands; parts of a position are one level deeper."""
        return f"{self.prefix}/{site}/{address.replace('.', '/')}"

    def command_ask(self, site: str, device: str, command: str) -> str:
        """Name where a command is asked for."""
        return f"{self.prefix}/{site}/{device}/{_ASK}/{command}"

    def command_answer(self, site: str, device: str, command: str) -> str:
        """Name where it is told what became of a command."""
        return f"{self.prefix}/{site}/{device}/{_ANSWER}/{command}"

    def stop_ask(self, site: str, device: str) -> str:
        """Name where STOP (software) is pressed."""
        return f"{self.prefix}/{site}/{device}/{_STOP}"

    def stop_answer(self, site: str, device: str) -> str:
        """Name where it is told that STOP is on, or why it could not be pressed."""
        return f"{self.prefix}/{site}/{device}/{_ANSWER}/{_STOP}"

    def command_filter(self, site: str) -> str:
        """Name all topics of a site where commands are asked for."""
        return f"{self.prefix}/{site}/+/{_ASK}/+"

    def stop_filter(self, site: str) -> str:
        """Name all topics of a site where STOP is pressed."""
        return f"{self.prefix}/{site}/+/{_STOP}"

    def read_command(self, topic: str) -> CommandTopic | None:
        """Tell what a topic asks for; None: nothing."""
        levels = topic.removeprefix(f"{self.prefix}/").split("/")
        if not topic.startswith(f"{self.prefix}/"):
            return None
        match levels:
            case [site, device, "$do", command] if site and device and command:
                return CommandTopic(site, device, command)
            case [site, device, "$stop"] if site and device:
                return CommandTopic(site, device, "")
            case _:
                return None
