"""Hands each new picture over to the owner's command or webhook: at least once, and in order.

What waits is in the database: a hub that was killed begins with the picture whose end it does not
know. One that is not taken is tried again for as long as it takes, and everything behind it waits:
whoever stacks or differences pictures relies on their order.
"""

from __future__ import annotations

import asyncio
import logging
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import msgspec

from talaia.hub.archive.obscore import number_or_none
from talaia.hub.child_end import finish_child
from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.archive.frame_queues import FrameQueues
    from talaia.hub.archive.frame_rows import ArchivedFrame
    from talaia.hub.archive.hook_settings import ArchiveHookSettings
    from talaia.hub.store.audit import Audit

__all__ = ["ArchiveHook", "HookCommand", "HookPost", "Hooked", "frame_document"]

log = logging.getLogger(__name__)
# After the first try that did not do, after the second, …, and then again and again (s).
_AGAIN_S = (1.0, 5.0, 30.0, 120.0, 600.0)
# Until the database is asked again after it did not answer (s).
_STORE_AGAIN_S = 5.0
_SURROUNDINGS = ("PATH", "LANG", "HOME")


class Hooked(Protocol):
    """Whoever takes pictures."""

    async def hand_over(self, document: dict[str, Any]) -> str:
        """Hand one over; gives why it was not taken, or nothing."""
        ...


class _Posts(Protocol):
    async def post_document(
        self, url: str, *, token: str, key: str, document: Mapping[str, object]
    ) -> str:
        """Post any JSON; gives why it was not taken, or nothing."""
        ...


class ArchiveHook:
    """The run of the queue."""

    def __init__(
        self,
        queues: FrameQueues,
        hooked: Hooked,
        audit: Audit,
        again_s: Sequence[float] = _AGAIN_S,
    ) -> None:
        """Hand what waits in ``queues`` over to ``hooked``; failures are written down.

        ``again_s``: how long it waits after the first try that did not do, the second, ….
        """
        self._again_s = again_s
        self._queues, self._hooked, self._audit = queues, hooked, audit

    async def run(self) -> None:
        """Hand over what comes, until cancelled."""
        while True:
            self._queues.measured.clear()
            try:
                while (frame := await self._queues.next_for_hook()) is not None:
                    await self._hand_over(frame)
                    await self._queues.mark_handed_over(frame)
            except StoreDown:
                await asyncio.sleep(_STORE_AGAIN_S)
                continue
            await self._queues.measured.wait()

    async def _hand_over(self, frame: ArchivedFrame) -> None:
        try:
            async with self._queues.frame_copy(frame) as path:
                await self._hand_file_over(frame, str(path))
        except FileNotFoundError:
            # Of one that is gone a hook still hears, as of one that somebody took out of a folder.
            await self._hand_file_over(frame, "")

    async def _hand_file_over(self, frame: ArchivedFrame, file: str) -> None:
        document = frame_document(frame, file, self._queues.frame_address(frame))
        tries = 0
        while problem := await self._hooked.hand_over(document):
            log.warning("%s is not taken by the archive's hook: %s", frame.name, problem)
            if tries == 0:
                # Once for each picture, not for each try.
                self._record(frame, f"{frame.name}: {problem}", good=False)
            await asyncio.sleep(self._again_s[min(tries, len(self._again_s) - 1)])
            tries += 1
        if tries:
            self._record(frame, f"{frame.name}: taken after {tries + 1} tries", good=True)

    def _record(self, frame: ArchivedFrame, message: str, *, good: bool) -> None:
        self._audit.append_record(
            "picture handed over" if good else "picture not handed over",
            site=frame.site,
            device=frame.device,
            message=message[:500],
            good=good,
        )


class HookCommand:
    """A program that reads a picture's facts on its input; it has taken it when it ends with 0."""

    def __init__(self, settings: ArchiveHookSettings, folder: Path) -> None:
        """Run it in ``folder``."""
        self._settings, self._folder = settings, folder

    async def hand_over(self, document: dict[str, Any]) -> str:
        """See `Hooked.hand_over`."""
        kept = {name: os.environ[name] for name in _SURROUNDINGS if name in os.environ}
        try:
            child = await asyncio.create_subprocess_exec(
                *self._settings.command,
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.DEVNULL,
                stderr=asyncio.subprocess.PIPE,
                # Secrets of the hub's are not among its surroundings, nor its files beside it.
                env=kept,
                cwd=self._folder,
                # What it makes is for the owner's pipeline; the hub's own files are private.
                umask=0o022,
                # A group of its own, so that what it started ends with it.
                start_new_session=True,
            )
        except OSError as error:
            return f"it could not be started: {error}"
        # On its input, never among its arguments: a target's name is a stranger's text.
        given = msgspec.json.encode(document) + b"\n"
        try:
            end = await finish_child(child, self._settings.timeout, given)
        except TimeoutError:
            return f"no end after {self._settings.timeout:g} s"
        return "" if end.code == 0 else f"it ended with {end.code}: {end.last_line[:300]}"


class HookPost:
    """A webhook; any answer of 200 to 299 means that it has taken the picture."""

    def __init__(self, settings: ArchiveHookSettings, sender: _Posts) -> None:
        """Post by ``sender``, which looks at every address it comes to."""
        self._settings, self._sender = settings, sender

    async def hand_over(self, document: dict[str, Any]) -> str:
        """See `Hooked.hand_over`."""
        token = ""
        if self._settings.token_file:
            # Read each time: whoever changes it does not restart the hub.
            try:
                token = (await asyncio.to_thread(Path(self._settings.token_file).read_text)).strip()
            except (OSError, UnicodeDecodeError) as error:
                return f"its token cannot be read: {error}"
        # The same key each time: a server can know a picture again that comes twice.
        return await self._sender.post_document(
            self._settings.url, token=token, key=f"frame-{document['id']}", document=document
        )


def frame_document(frame: ArchivedFrame, file: str, address: str = "") -> dict[str, Any]:
    """Give what a hook is told of a picture; what is not known is null.

    ``file`` is on this machine's disk; ``address`` is that of a bucket, where it is in one.
    """
    measures = frame.measures
    return {
        "id": str(frame.id),
        "site": frame.site,
        "device": frame.device,
        "night": frame.night,
        "name": frame.name,
        "file": file,
        "address": address,
        "time_us": frame.time_us,
        "target": frame.target,
        "filter": frame.filter,
        "kind": frame.kind,
        "exposure_s": number_or_none(frame.exposure_s),
        "ra_deg": number_or_none(frame.ra_deg),
        "dec_deg": number_or_none(frame.dec_deg),
        "stars": measures.stars,
        "fwhm": number_or_none(measures.fwhm),
        "background": number_or_none(measures.background),
        "zero_point": number_or_none(measures.zero_point),
        "solved": bool(measures.wcs),
        "note": measures.note,
    }
