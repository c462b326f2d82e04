"""Changes of the description while the gateway runs: of its own file, and asked for by the hub.

One after the other. Whatever is wrong with a change, the description that counts stays.
Long, because the way of a change is read from end to end.
"""

from __future__ import annotations

import asyncio
import hmac
import logging
from functools import partial
from typing import TYPE_CHECKING

from talaia.errors import TalaiaError
from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.change_policy import forbidden_changes
from talaia.gateway.reload.current_description import prepare_description
from talaia.gateway.reload.discovered_devices import with_kept
from talaia.gateway.reload.refusals import (
    ChangeRefused,
    mistake_line,
    refusal_of,
    without_lines,
    wrong_text,
)
from talaia.model.checks.identifiers import Finding
from talaia.model.checks.ros_types.ros_type_checks import ros_type_findings
from talaia.model.checks.site_checks import check_site
from talaia.model.checks.text_checks import Mistake, check_text, place_findings
from talaia.model.derived_signals import with_counts
from talaia.model.errors import DescriptionError, NotReadable
from talaia.model.yaml_text.load import plain_of_text, site_in
from talaia.model.yaml_text.shape_errors import list_shape_errors
from talaia.ros_type_library import RosTypeLibrary
from talaia.wire.errors import PeerError
from talaia.wire.frames import ChangePhase, ChangeState
from talaia.wire.sealing import decompress_text, seal_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from talaia.gateway.ports import EventSink
    from talaia.gateway.reload.apply import DescriptionReload
    from talaia.gateway.reload.description_file import DescriptionFile
    from talaia.model.site import Site
    from talaia.wire.frames import ChangeRequest

__all__ = ["ChangeRequests"]

log = logging.getLogger(__name__)
# Between two looks at the file, s.
LOOK_S = 0.5
# A look at the file that takes longer is told of: a disk or a network drive that does not answer.
SLOW_LOOK_S = 10.0
# So often it is looked whether what hinders a change is over.
AGAIN_S = 0.05
# Zeros last for ten seconds at the most; a device whose zeros never end is not to hold up others.
LEFT_S = 12.0
# Types and fields that nothing here has, each with a line of its own in the logbook; mistakes, too.
_MOST_DOUBTS = _MOST_TOLD = 10
# Ended changes whose answer may be asked for again after a lost link.
MOST_REMEMBERED = 50


class ChangeRequests:
    """Takes changes in, judges them, and sees each through."""

    def __init__(
        self,
        *,
        file: DescriptionFile | None,
        accepts: AcceptedChanges,
        key_hash: str,
        data: Path,
        reload: DescriptionReload,
        send: Callable[[ChangeState], None],
        events: EventSink,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
        slow_look_s: float = SLOW_LOOK_S,
    ) -> None:
        """Judge by what the gateway permits.

        Args:
            file: the file; none where the description is not from one.
            accepts: what may come from the hub.
            key_hash: SHA-256 of the gateway's key, hex; see `wire.sealing`.
            data: the data folder, which has the devices that were found.
            reload: puts a description in the place of another.
            send: tells the hub.
            events: told what is worth writing down.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.
            slow_look_s: a look at the file that takes longer is told of.

        """
        self._file = file  # None where the description is not from a file; then nothing is watched.
        self._accepts = accepts  # What may come from the hub; set by whoever starts the gateway.
        # SHA-256 of the key: a change must be sealed with it, so a hub alone cannot make one up.
        self._key_hash = key_hash
        self._data = data  # Devices that were found are joined to each new text.
        self._reload = reload  # Puts a description in the place of another.
        self._send = send  # To the hub.
        self._events = events  # For the record.
        self._on_disk = on_disk  # Runs writes in order.
        self._slow_look_s = slow_look_s  # A look at the file that takes longer is told of.
        self._turn = asyncio.Lock()  # One change at a time, whether of the file or of the hub.
        self._known: dict[str, ChangeState] = {}  # By id: how asked changes stand, oldest first.
        # What is wrong with the file as it stands now, if anything.
        self._standing: ChangeState | None = None

    def link_up(self) -> None:
        """Tell a new link what is wrong with the file."""
        if self._standing is not None:
            self._send(self._standing)

    # ── the file ──

    async def watch_file(self) -> None:
        """Follow the file until cancelled."""
        if self._file is None:
            await asyncio.Event().wait()
            return
        while True:
            await asyncio.sleep(LOOK_S)
            try:
                text = await self._look_at(self._file)
            except DescriptionError as error:
                self._report_refused(refusal_of(error))
                continue
            if text is not None:
                await self._follow_text(text)

    async def _look_at(self, file: DescriptionFile) -> str | None:
        # A thread that hangs in a system call cannot be ended: it is waited for, and told of once.
        look = asyncio.ensure_future(asyncio.to_thread(file.read_change))
        done, _ = await asyncio.wait({look}, timeout=self._slow_look_s)
        if done:
            return look.result()
        what = f"has not been answered for {self._slow_look_s:g} s by where it is kept"
        slow = NotReadable(str(file.path), what, "what counted before goes on")
        self._report_refused(refusal_of(slow))
        text = await look
        log.warning("the description's file is answered again")
        self._clear_problem()
        return text

    async def _follow_text(self, text: str) -> None:
        file = self._file
        assert file is not None  # noqa: S101 - it has just been read
        async with self._turn:
            site = await asyncio.to_thread(self._read_text, text)
            if isinstance(site, ChangeRefused):
                self._report_refused(site)
                return
            if site == self._reload.now.site and text == self._reload.now.source:
                self._clear_problem()
                return
            if site.site != self._reload.now.site.site:
                where = Finding("$.site", "a site keeps its short name while it runs")
                self._report_refused(
                    ChangeRefused("the description is of another site", without_lines([where]))
                )
                return
            while hindrance := self._reload.reload_hindrance(site):
                log.info("the description waits: %s", hindrance)
                while self._reload.reload_hindrance(site):  # noqa: ASYNC110 - rare, told by nobody
                    await asyncio.sleep(AGAIN_S)
            refused = await self._apply_change(site, text, "", "")
        if refused is not None:
            self._report_refused(refused)
        else:
            self._clear_problem()
            await self._report_types(site, text)

    async def _report_types(self, site: Site, text: str) -> None:
        """Say which types and fields of ROS a description names that nothing here has.

        It counts all the same: a robot may describe its types itself, once it runs.
        """
        assert self._file is not None  # noqa: S101 - a description without a file is never followed
        folder = self._file.path.parent
        named = [getattr(link, "definitions", "") for link in site.links().values()]

        def list_doubts() -> list[Mistake]:
            library = RosTypeLibrary(folder / one for one in named if one)
            return place_findings(ros_type_findings(site, library).mistakes, text)

        found = await asyncio.to_thread(list_doubts)
        for mistake in found[:_MOST_DOUBTS]:
            line = mistake_line(mistake, self._file.path.name)
            log.warning("the changed description: %s", line)
            self._events.report_event("description_doubtful", line)
        if (more := len(found) - _MOST_DOUBTS) > 0:
            self._events.report_event("description_doubtful", f"{more} more: run talaia check")

    def _report_refused(self, refused: ChangeRefused) -> None:
        """Say once what is wrong with the file; what counted before goes on."""
        name = "" if self._file is None else self._file.path.name
        said = [mistake_line(one, name) for one in refused.problems] or [refused.message]
        if (more := len(said) - _MOST_TOLD) > 0:
            said[_MOST_TOLD:] = [f"{more} more: run talaia check"]
        for line in said:
            log.warning("the changed description is not used: %s", line)
        # Told again to each new link; the file may stand wrong for days.
        self._standing = refused.change_state("")
        self._send(self._standing)
        for line in said:
            self._events.report_event("description_refused", line)

    def _clear_problem(self) -> None:
        if self._standing is not None:
            self._standing = None
            self._send(ChangeState(phase=ChangePhase.APPLIED))

    # ── the hub ──

    async def handle_request(self, asked: ChangeRequest) -> None:
        """Judge a change that the hub hands on, and tell how it ends. A known id is answered."""
        known = self._known.get(asked.id)
        if known is not None:
            self._send(known)
            return
        self._report_state(ChangeState(id=asked.id, phase=ChangePhase.WAITING))
        async with self._turn:
            try:
                refused = await self._judge_request(asked)
            except Exception:
                log.exception("the change %s failed", asked.id)
                refused = ChangeRefused("the gateway failed; see its log")
        if refused is None:
            self._report_state(ChangeState(id=asked.id, phase=ChangePhase.APPLIED))
            return
        self._report_state(refused.change_state(asked.id))
        said = [mistake_line(one) for one in refused.problems[:1]] or [refused.message]
        self._events.report_event("change_refused", said[0], who=asked.who)

    def _report_state(self, state: ChangeState) -> None:
        self._known[state.id] = state
        while len(self._known) > MOST_REMEMBERED:
            self._known.pop(next(iter(self._known)))
        self._send(state)

    async def _judge_request(self, asked: ChangeRequest) -> ChangeRefused | None:
        file, now = self._file, self._reload.now
        try:
            text = decompress_text(asked.source)
        except PeerError as error:
            return ChangeRefused(str(error))
        # Compared in constant time: the seal must not be found byte by byte.
        seal = seal_of(
            self._key_hash, change_id=asked.id, who=asked.who, base=asked.base, text=text
        )
        if not hmac.compare_digest(seal, asked.seal):
            return ChangeRefused("the change is not sealed with this gateway's key")
        if self._accepts is AcceptedChanges.NO or file is None or not file.editable:
            findings = forbidden_changes(now.site, now.site, AcceptedChanges.NO)
            return ChangeRefused(
                "this gateway takes no changes from the hub", without_lines(findings)
            )
        # Two people at two pages: the second begins with what the first has made.
        if asked.base != file.digest:
            return ChangeRefused(
                "the description has been changed meanwhile; begin with the newest one"
            )
        site = await asyncio.to_thread(self._read_text, text)
        if isinstance(site, ChangeRefused):
            return site
        if findings := forbidden_changes(now.site, site, self._accepts):
            return ChangeRefused(
                "this gateway does not take such a change from the hub", without_lines(findings)
            )
        if hindrance := self._reload.reload_hindrance(site):
            return ChangeRefused(f"{hindrance}; wait for its end, or cancel it, and ask again")
        return await self._apply_change(site, text, asked.id, asked.who)

    # ── both ──

    def _read_text(self, text: str) -> Site | ChangeRefused:
        """Read and check a text as if it stood in the file; any thread."""
        assert self._file is not None  # noqa: S101 - there is a text because there is a file
        try:
            site = site_in(text, self._file.path)
        except DescriptionError as error:
            return _all_mistakes(text) or refusal_of(error, text)
        findings = check_site(site)
        if findings:
            return wrong_text(findings, text)
        return with_counts(with_kept(self._data, site))

    async def _apply_change(
        self, site: Site, text: str, change_id: str, who: str
    ) -> ChangeRefused | None:
        file, reload = self._file, self._reload
        assert file is not None  # noqa: S101 - see `_read_text`
        source = text if file.editable else ""
        next_ = await asyncio.to_thread(prepare_description, site, source)
        reload.leave_touched(site)
        try:
            async with asyncio.timeout(LEFT_S):
                while not reload.has_left(site):  # noqa: ASYNC110 - told by nobody
                    await asyncio.sleep(AGAIN_S)
            before = file.text
            if change_id:
                # File before gateway: after a crash between the two the next run has what was asked
                # for.
                await self._on_disk(partial(file.write_text, text))
            try:
                reload.apply_description(next_, change_id, who)
            except TalaiaError:
                if change_id:
                    # The parts refused it: the file must not begin the next run with it.
                    await self._on_disk(partial(file.write_text, before))
                raise
        except TimeoutError:
            # Whatever was about to change may be driven again.
            reload.leave_touched(None)
            return ChangeRefused("a device that it touches does not come to rest")
        except OSError as error:
            reload.leave_touched(None)
            return ChangeRefused(
                f"the gateway cannot write {file.path.name}: {error.strerror or error}"
            )
        except TalaiaError as error:
            reload.leave_touched(None)
            return ChangeRefused(str(error))
        file.accept_text(site, text)
        log.info("the description was changed%s", f" by {who}" if who else "")
        return None


def _all_mistakes(text: str) -> ChangeRefused | None:
    """Give all that a text of the wrong shape has wrong; None where its shape is right."""
    try:
        wrong = list_shape_errors(plain_of_text(text)).errors
    except DescriptionError:
        # No YAML at all: that is all there is to say.
        return None
    # What is wrong is a file beside it, then.
    if not wrong:
        return None
    mistakes = tuple(check_text(text).mistakes)
    return ChangeRefused("the description cannot be used as written", mistakes)
