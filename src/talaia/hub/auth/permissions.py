"""Who may do what, decided from values alone.

A permission is a right on a whole site or on one device. Roles hold permissions as data. What a
description marks as public is seen by everyone who is signed in, without any permission.

Long, because who may have what is decided in one place.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from talaia.model.alarms.signal_groups import group_named
from talaia.model.site import Visibility
from talaia.model.topics import (
    TopicRight,
    blurred_cameras,
    blurred_topics,
    calibrated_cameras,
    carries_pictures,
    rule_of,
)

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = [
    "ANY",
    "Grants",
    "Permission",
    "Right",
    "Who",
    "may_tap",
    "seen_camera",
    "sees_device",
    "sees_signal",
    "sees_site",
    "sees_stream",
    "sees_unblurred",
]

ANY = "*"  # stands for every site, or every device of a site


class Right(StrEnum):
    """What a permission allows: ``use`` includes ``view``, and ``admin`` includes all others.

    ``tap`` and ``metrics`` stand beside: who has the one may have the robot's raw topics, who has
    the other may read figures for monitoring, and nothing else by it. So do ``request`` (ask for
    observations in the name of a proposal), ``approve`` (let them be observed, see all of them)
    and ``arm`` (let the night run by itself). ``unblurred`` adds to what may be seen: pictures of
    blurred cameras as they are.
    """

    VIEW = "view"
    USE = "use"
    TAP = "tap"
    METRICS = "metrics"
    REQUEST = "request"
    APPROVE = "approve"
    ARM = "arm"
    UNBLURRED = "unblurred"
    ADMIN = "admin"


# What having a right includes.
_INCLUDES = {
    Right.VIEW: frozenset({Right.VIEW}),
    Right.USE: frozenset({Right.VIEW, Right.USE}),
    Right.TAP: frozenset({Right.TAP}),
    Right.METRICS: frozenset({Right.METRICS}),
    Right.REQUEST: frozenset({Right.REQUEST}),
    Right.APPROVE: frozenset({Right.APPROVE}),
    Right.ARM: frozenset({Right.ARM}),
    Right.UNBLURRED: frozenset({Right.UNBLURRED}),
    Right.ADMIN: frozenset(Right),
}
# Having which rights a right is given.
_INCLUDED = {
    right: frozenset(held for held, includes in _INCLUDES.items() if right in includes)
    for right in Right
}


@dataclass(frozen=True, slots=True)
class Permission:
    """A right on a site and a device; ``*`` stands for each of them."""

    right: Right
    site: str = ANY
    device: str = ANY

    def covers(self, right: Right, site: str, device: str) -> bool:
        """Tell whether this allows ``right`` on a device; ``*`` asks for all of them."""
        return (
            # Asked for all devices, one on a single device does not do.
            self.right in _INCLUDED[right]
            and self.site in {ANY, site}
            and self.device in {ANY, device}
        )


@dataclass(frozen=True, slots=True)
class Grants:
    """The permissions of one person."""

    permissions: frozenset[Permission] = frozenset()

    def has_right(self, right: Right, site: str, device: str = ANY) -> bool:
        """Tell whether a person has ``right`` on one device, or (``*``) on the whole site."""
        return any(permission.covers(right, site, device) for permission in self.permissions)

    def covers(self, asked: Permission) -> bool:
        """Tell whether a person could give ``asked`` away, since they have all of it."""
        return self.has_right(asked.right, asked.site, asked.device)

    def limited_to(self, to: frozenset[Permission]) -> Grants:
        """Give what of these ``to`` leaves: never more than either."""
        met = (_intersect_permissions(ours, theirs) for ours in self.permissions for theirs in to)
        found = {match for match in met if match is not None}
        # What another one includes is left out, so that people read as few as there are.
        return Grants(
            frozenset(
                permission
                for permission in found
                if not any(
                    other != permission
                    and other.covers(permission.right, permission.site, permission.device)
                    for other in found
                )
            )
        )

    def devices(self, right: Right, site: str) -> frozenset[str] | None:
        """Name the devices of a site on which a person has ``right``; None is the whole site.

        Those of former descriptions are among them, since a permission outlives what it is for.
        """
        # None instead of a list: devices that the description will have later are in it, too.
        if self.has_right(right, site):
            return None
        return frozenset(
            permission.device
            for permission in self.permissions
            if permission.covers(right, site, permission.device)
        )

    def rights_on(self, site: str, device: str) -> list[Right]:
        """List the rights on a device, of those that include one another."""
        ladder = (Right.VIEW, Right.USE, Right.ADMIN)
        return [right for right in ladder if self.has_right(right, site, device)]


@dataclass(frozen=True, slots=True)
class Who:
    """A person who is signed in, or a script with a token of theirs.

    Attributes:
        session: names the session (or the token) without being of use to open one.
        factor: whether the person signs in with a second factor.
        factor_required: whether the role requires one.
        script: whether it is a token that asks; it may manage nothing.
        display: whether it is a screen's token: it only looks.

    """

    # The end of it ends every socket that was opened with it.
    session: str
    user: int
    name: str
    role: str
    grants: Grants
    factor: bool = False
    script: bool = False
    display: bool = False
    factor_required: bool = False

    @property
    def factor_missing(self) -> bool:
        """Whether a second factor has to be set up before anything else."""
        return self.factor_required and not self.factor


def _intersect_permissions(ours: Permission, theirs: Permission) -> Permission | None:
    """Give what both allow; None when they have nothing in common."""
    site, device = (
        _narrower_name(ours.site, theirs.site),
        _narrower_name(ours.device, theirs.device),
    )
    # Each is for another place: there is nothing that both allow.
    if site is None or device is None:
        return None
    # The lesser of the two; of two that stand beside each other nothing is left.
    if ours.right in _INCLUDES[theirs.right]:
        return Permission(ours.right, site, device)
    if theirs.right in _INCLUDES[ours.right]:
        return Permission(theirs.right, site, device)
    return None


def _narrower_name(one: str, other: str) -> str | None:
    # Of "everything" and a name the name is left; of two names only the same one.
    if ANY in {one, other}:
        return other if one == ANY else one
    return one if one == other else None


def sees_signal(grants: Grants, site: Site, device: str, signal: str) -> bool:
    """Tell whether a person may see a signal; False when there is none.

    Without a device it is a group of signals (`group_address`): who sees all of them sees it, for
    what is said of a group tells of each of them.
    """
    if not device:
        group = group_named(site, signal)
        return group is not None and all(
            sees_signal(grants, site, *address.split("/", 1)) for address in group.signals
        )
    described = site.devices.get(device)
    found = described.signals.get(signal) if described else None
    # What is not there looks like what may not be seen.
    if found is None:
        return False
    return found.visibility is Visibility.PUBLIC or grants.has_right(Right.VIEW, site.site, device)


def sees_stream(grants: Grants, site: Site, device: str, stream: str) -> bool:
    """Tell whether a person may see a camera's pictures; False when there is none."""
    described = site.devices.get(device)
    found = described.streams.get(stream) if described else None
    if found is None:
        return False
    return found.visibility is Visibility.PUBLIC or grants.has_right(Right.VIEW, site.site, device)


def seen_camera(grants: Grants, site: Site, topic: str, type_name: str) -> str:
    """Name the described camera, ``device/stream``, that a calibration's topic speaks of.

    Args:
        grants: the person's.
        site: the description.
        topic: absolute name.
        type_name: of its messages.

    Returns:
        The first one that the person may see; empty where there is none.

    """
    cameras = calibrated_cameras(site, topic, type_name)
    return next((one for one in cameras if sees_stream(grants, site, *one.split("/", 1))), "")


def sees_unblurred(grants: Grants, site: Site, device: str, stream: str) -> bool:
    """Tell whether a person may see the pictures of a blurred camera as they are."""
    return sees_stream(grants, site, device, stream) and grants.has_right(
        Right.UNBLURRED, site.site, device
    )


def may_tap(
    grants: Grants, site: Site, topic: str, *, type_name: str = "", definition: str = ""
) -> bool:
    """Tell whether a person may have a raw topic, by the rules of the site's description.

    A topic that no rule names is for those who have the right ``tap`` on the whole site. Where a
    camera is blurred, one that may show its pictures as they are is for those who may see them.

    Args:
        grants: the person's.
        site: the description.
        topic: absolute name.
        type_name: of its messages; empty while it is not known.
        definition: what that type is made of; empty while it is not known.

    """
    return _is_topic_allowed(grants, site, topic) and _may_be_unblurred(
        grants, site, topic, carries_pictures(type_name, definition)
    )


def _may_be_unblurred(grants: Grants, site: Site, topic: str, pictures: bool) -> bool:  # noqa: FBT001
    if not blurred_cameras(site):
        return True
    device = blurred_topics(site).get(topic)
    # Which of the robot's cameras another topic with pictures shows, nobody knows.
    place = ANY if device is None and pictures else device
    return place is None or grants.has_right(Right.UNBLURRED, site.site, place)


def _is_topic_allowed(grants: Grants, site: Site, topic: str) -> bool:
    rule = rule_of(site.topics, topic)
    if rule is None:
        return grants.has_right(Right.TAP, site.site)
    device = rule.device or ANY
    if grants.has_right(Right(rule.right.value), site.site, device):
        return True
    return rule.right is not TopicRight.ADMIN and grants.has_right(Right.TAP, site.site, device)


def sees_device(grants: Grants, site: Site, device: str) -> bool:
    """Tell whether a person may know of a device: it, or something of it, is open to them."""
    described = site.devices.get(device)
    if described is None:
        return False
    if described.visibility is Visibility.PUBLIC or grants.has_right(Right.VIEW, site.site, device):
        return True
    # A public signal or picture makes its device known, but not the rest of it.
    signals = (signal.visibility for signal in described.signals.values())
    streams = (stream.visibility for stream in described.streams.values())
    return Visibility.PUBLIC in {*signals, *streams}


def sees_site(grants: Grants, site: Site) -> bool:
    """Tell whether a person may know of a site: any of its devices is open to them."""
    return any(sees_device(grants, site, device) for device in site.devices)
