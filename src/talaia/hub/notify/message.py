"""What a message says. Pure."""

from __future__ import annotations

import base64
import datetime as dt
from typing import TYPE_CHECKING, NamedTuple
from zoneinfo import ZoneInfo

from talaia.hub.alarms.state_machine import What
from talaia.hub.auth.permissions import ANY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.store.alarms.notification_outbox import OutboxNotice

__all__ = ["AlarmMessage", "AlarmPicture", "compose_message", "compose_test_message"]

_ALARMS = "/alarms"  # path of the page of all alarms
_START = "/"
_WORDS = {What.CLEARED: "over: ", What.REMINDED: "still: "}


class AlarmPicture(NamedTuple):
    """What a camera saw.

    Attributes:
        jpeg: the picture itself.
        path: where the hub shows it to those who may see it.

    """

    jpeg: bytes
    path: str


class AlarmMessage(NamedTuple):
    """A message, the same by whatever way it goes.

    Attributes:
        key: names it; the same when it is sent again.
        severity: of the worst in it.
        sites: whom it is about.
        open: path of the hub's page that shows it.
        picture: of what a camera saw, JPEG as base64; empty for none.
        picture_path: where the hub shows it to those who may see it.

    """

    key: str
    title: str
    body: str
    severity: str
    sites: tuple[str, ...]
    open: str = _ALARMS
    picture: str = ""
    picture_path: str = ""

    def with_picture(self, picture: AlarmPicture | None) -> AlarmMessage:
        """Give the message with a picture, if there is one."""
        if picture is None:
            return self
        text = base64.b64encode(picture.jpeg).decode()
        return self._replace(picture=text, picture_path=picture.path)


def compose_message(key: str, notices: Sequence[OutboxNotice], zone: str) -> AlarmMessage:
    """Write one message of one or more things that happened; times in the person's zone."""
    local = ZoneInfo(zone)
    # By rank, since words do not sort by how bad they are.
    worst = max(notices, key=lambda notice: notice.severity.rank)
    sites = tuple(dict.fromkeys(notice.site for notice in notices))
    # If nothing is left that is on, the title says so instead of naming a worst.
    raised = [notice for notice in notices if notice.what is not What.CLEARED]
    first = notices[0]
    if len(notices) == 1:
        title = f"{_WORDS.get(first.what, '')}{first.title} ({first.severity})"
    elif raised:
        title = f"{len(notices)} alarm messages, the worst {worst.severity}: {worst.title}"
    else:
        title = f"{len(notices)} alarms are over"
    body = "\n\n".join(_notice_line(notice, local) for notice in notices)
    about = {(notice.site, notice.alarm) for notice in notices}
    # Of several there is no one page but that of all.
    shown = f"{_ALARMS}?alarm={first.site}/{first.alarm}" if len(about) == 1 else _ALARMS
    if not any(notice.alarm for notice in notices):
        # Of requests for observations alone; or of the nights of one site.
        of_a_night = len(sites) == 1 and all(notice.device == ANY for notice in notices)
        shown = f"/sites/{sites[0]}/night" if of_a_night else _START
    return AlarmMessage(key, title, body, worst.severity.value, sites, shown)


def compose_test_message(key: str, who: str) -> AlarmMessage:
    """Write a message that only shows that one arrives."""
    return AlarmMessage(
        key,
        "Talaia: a test message",
        f"{who} asked for this test. Messages about alarms come the same way.",
        "info",
        (),
    )


def _notice_line(notice: OutboxNotice, zone: ZoneInfo) -> str:
    moment = dt.datetime.fromtimestamp(notice.time_us / 1e6, zone)
    head = f"{moment:%Y-%m-%d %H:%M:%S %Z}  {_WORDS.get(notice.what, '')}{notice.title}"
    return f"{head} ({notice.severity})\n{notice.text}"
