"""What a message between page and hub is about; the hub's rights are decided by it.

Every message of the closed lists has one of these bases, and so a method `subject`: whoever adds
a message has to say what it is about before the type checker lets it reach `MessageAuthorizer`.
The bases have no fields, since the order of a message's fields is the order on the wire.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from talaia.wire.message import Message

__all__ = ["DeviceMessage", "MessageSubject", "SessionMessage", "SiteMessage", "StreamMessage"]


class MessageSubject(NamedTuple):
    """The object that a message is about.

    Attributes:
        site: empty: no object, only the session itself.
        device: empty: the whole site.
        stream: of the device; empty: no camera.

    """

    site: str = ""
    device: str = ""
    stream: str = ""


# For the type checker alone: what a message needs for the bases below. ``self`` is annotated with
# them, so that a message without the field does not pass.
class _HasSite(Protocol):
    @property
    def site(self) -> str: ...


class _HasDevice(_HasSite, Protocol):
    @property
    def device(self) -> str: ...


class _HasCamera(_HasSite, Protocol):
    @property
    def camera(self) -> str: ...


class SessionMessage(Message, frozen=True, kw_only=True):
    """About nothing but the session."""

    def subject(self) -> MessageSubject:
        """Name what it is about."""
        return MessageSubject()


class SiteMessage(Message, frozen=True, kw_only=True):
    """About a site: has a field ``site``."""

    def subject(self: _HasSite) -> MessageSubject:
        """Name what it is about."""
        return MessageSubject(self.site)


class DeviceMessage(Message, frozen=True, kw_only=True):
    """About a device: has fields ``site`` and ``device``; an empty device is the whole site."""

    def subject(self: _HasDevice) -> MessageSubject:
        """Name what it is about."""
        return MessageSubject(self.site, self.device)


class StreamMessage(Message, frozen=True, kw_only=True):
    """About a camera: has fields ``site`` and ``camera``, which is ``<device>/<stream>``."""

    def subject(self: _HasCamera) -> MessageSubject:
        """Name what it is about."""
        # Without a slash the stream is empty, and the right is asked of the device.
        device, _, stream = self.camera.partition("/")
        return MessageSubject(self.site, device, stream)
