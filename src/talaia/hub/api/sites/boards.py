"""Boards: listed, read, saved with versions, shared, and as files.

Long, because every route of boards is here, with the look at the board that each takes.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec
from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.tile_schemas import (
    BoardAsk,
    BoardChangeAsk,
    BoardDetail,
    BoardList,
    BoardPlaceShape,
    BoardReading,
    BoardRestoreAsk,
    BoardRow,
    BoardSaved,
    BoardShape,
    BoardShareAsk,
    BoardText,
    BoardTileShape,
    BoardVersionList,
    BoardVersionShape,
)
from talaia.hub.auth.board_access import (
    BoardShare,
    BoardSubject,
    may_change,
    may_share,
    sees_board,
)
from talaia.hub.auth.permissions import sees_site
from talaia.hub.store.sites.boards import MOST_BOARDS
from talaia.model.boards.board import BoardOpenness
from talaia.model.boards.board_checks import board_findings
from talaia.model.boards.board_file import convert_board, dump_board, load_board
from talaia.model.errors import DescriptionError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.auth.permissions import Who
    from talaia.hub.ports import DescribedSite, DescribedSites
    from talaia.hub.store.accounts.roles import Roles
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.boards import Boards, KeptBoard
    from talaia.model.boards.board import Board, TilePlace

__all__ = ["BoardPages"]

# Between the site and the board of a description; no name of either has one.
_COLON = ":"
_UNKNOWN = "there is no such board"
_SHARING = "to share a board takes the right use at its site; other roles take an admin"


class BoardPages:
    """The routes of boards."""

    def __init__(
        self, *, boards: Boards, roles: Roles, sites: DescribedSites, audit: Audit
    ) -> None:
        """Answer from ``boards``, and from the descriptions of ``sites``."""
        self._boards = boards
        self._roles = roles
        self._sites = sites
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/boards")(self.overview)
        router.post("/api/boards")(self.add)
        router.post("/api/boards/text")(self.write_text)
        router.post("/api/boards/reading")(self.read_text)
        at = "/api/boards/{board}"
        router.get(at)(self.detail)
        router.put(at)(self.change)
        router.delete(at, status_code=204)(self.remove)
        router.put(at + "/share", status_code=204)(self.share)
        router.put(at + "/public", status_code=204)(self.publish)
        router.get(at + "/versions")(self.versions)
        router.get(at + "/versions/{number}")(self.version)
        router.post(at + "/versions/{number}/restore")(self.restore)
        return router

    async def overview(self, request: Request) -> BoardList:
        """List the boards that are open to you: yours, those shared with you, those described."""
        who = who_of(request)
        kept = [
            _row_of(board, who)
            for board in await self._boards.list_boards()
            if sees_board(who, board.subject)
        ]
        described = [
            _row_of_described(live, name, board)
            for live in self._sites
            for name, board in live.description.boards.items()
            if _sees_described(who, live, board)
        ]
        return BoardList(boards=[*kept, *described])

    async def detail(self, board: str, request: Request) -> BoardDetail:
        """Give a board as it is now."""
        found = self._find_described(board, who_of(request))
        if found is not None:
            live, name, described = found
            row = _row_of_described(live, name, described)
            return BoardDetail(row=row, number=row.number, board=_shape_of(described))
        return await self._detail_of(await self._find_board(board, request), None, request)

    async def add(self, asked: BoardAsk, request: Request) -> BoardSaved:
        """Keep a new board. You alone see it until you share it."""
        who = who_of(request)
        board = _board_of(asked.board)
        key = await self._boards.add_board(board, who.user, who.name, asked.note)
        if key is None:
            raise ApiProblem(409, "busy", f"you have {MOST_BOARDS} boards; remove some first")
        self._append_record(request, "board made", f"{board.name} ({key})", board.site)
        return BoardSaved(key=key, number=1)

    async def change(self, board: str, asked: BoardChangeAsk, request: Request) -> BoardSaved:
        """Keep another version of a board."""
        kept = await self._find_changeable(board, request)
        return await self._save(
            kept, _board_of(asked.board), base=asked.base, note=asked.note, request=request
        )

    async def remove(self, board: str, request: Request) -> None:
        """Remove a board with all its versions."""
        kept = await self._find_changeable(board, request)
        await self._boards.remove_board(kept)
        self._append_record(
            request, "board removed", f"{kept.name} ({kept.key})", kept.subject.site
        )

    async def share(self, board: str, asked: BoardShareAsk, request: Request) -> None:
        """Open a board to a role or to those who see its site; or keep it to its owner."""
        kept = await self._find_changeable(board, request)
        share = BoardShare(asked.share)
        if share is BoardShare.ROLE and asked.role not in {
            role.name for role in await self._roles.list_roles()
        }:
            raise ApiProblem(422, "invalid", f"there is no role {asked.role!r}")
        await self._share_board(kept, share, asked.role, request)

    async def publish(self, board: str, request: Request) -> None:
        """Open a board to everybody who is signed in, and to every display."""
        kept = await self._find_changeable(board, request)
        await self._share_board(kept, BoardShare.PUBLIC, "", request)

    async def versions(self, board: str, request: Request) -> BoardVersionList:
        """List a board's versions."""
        kept = await self._find_board(board, request)
        return BoardVersionList(
            versions=[
                BoardVersionShape(**version._asdict())
                for version in await self._boards.list_versions(kept)
            ]
        )

    async def version(self, board: str, number: str, request: Request) -> BoardDetail:
        """Give a version of a board."""
        kept = await self._find_board(board, request)
        return await self._detail_of(kept, number_of(number, "version"), request)

    async def restore(
        self, board: str, number: str, asked: BoardRestoreAsk, request: Request
    ) -> BoardSaved:
        """Go back to a version: it becomes the newest one, and none is lost."""
        kept = await self._find_changeable(board, request)
        wanted = number_of(number, "version")
        before = await self._boards.read_version(kept, wanted)
        if before is None:
            raise ApiProblem(404, "unknown", "there is no such version")
        note = f"back to version {wanted}"
        return await self._save(kept, before, base=asked.base, note=note, request=request)

    async def write_text(self, asked: BoardAsk) -> BoardText:
        """Give a board as the text of a file. Nothing is kept."""
        return BoardText(text=await asyncio.to_thread(dump_board, _board_of(asked.board)))

    async def read_text(self, asked: BoardText) -> BoardReading:
        """Read the text of a file. Nothing is kept."""
        try:
            board = await asyncio.to_thread(load_board, asked.text)
        except DescriptionError as error:
            return BoardReading(
                board=None, where=error.where, problem=error.problem, remedy=error.remedy
            )
        return BoardReading(board=_shape_of(board), where="", problem="", remedy="")

    async def _save(
        self, kept: KeptBoard, board: Board, *, base: int, note: str, request: Request
    ) -> BoardSaved:
        # Of another site other people see it: it is shared with them by this.
        moved = kept.subject._replace(site=board.site)
        if (
            moved.share is BoardShare.VIEW
            and moved != kept.subject
            and not may_share(who_of(request), moved, BoardShare.VIEW, "")
        ):
            raise ApiProblem(403, "forbidden", _SHARING)
        number = await self._boards.save_version(
            kept, board, base=base, who=who_of(request).name, note=note
        )
        # Two who arrange at once: the second must see what the first has done.
        if number is None:
            raise ApiProblem(409, "changed", "the board was changed meanwhile; load it anew")
        said = f"{board.name} ({kept.key}), version {number}" + (f": {note}" if note else "")
        self._append_record(request, "board changed", said, board.site)
        return BoardSaved(key=kept.key, number=number)

    async def _share_board(
        self, kept: KeptBoard, share: BoardShare, role: str, request: Request
    ) -> None:
        if not may_share(who_of(request), kept.subject, share, role):
            raise ApiProblem(403, "forbidden", _SHARING)
        await self._boards.share_board(kept, share, role)
        whom = f"role {role}" if share is BoardShare.ROLE else share.value
        said = f"{kept.name} ({kept.key}) with: {whom}"
        self._append_record(request, "board shared", said, kept.subject.site)

    async def _find_board(self, key: str, request: Request) -> KeptBoard:
        # What no key can be is asked of no database; that of a description has no versions.
        kept = await self._boards.find_board(key) if key.isascii() and key.isalnum() else None
        # The same words whether it is hidden or not there at all.
        if kept is None or not sees_board(who_of(request), kept.subject):
            raise ApiProblem(404, "unknown", _UNKNOWN)
        return kept

    async def _find_changeable(self, key: str, request: Request) -> KeptBoard:
        if self._find_described(key, who_of(request)) is not None:
            problem = "this board is of its site's description; save a copy, or change it there"
            raise ApiProblem(409, "described", problem)
        kept = await self._find_board(key, request)
        if not may_change(who_of(request), kept.subject):
            raise ApiProblem(403, "forbidden", "this board is somebody else's; save a copy")
        return kept

    def _find_described(self, key: str, who: Who) -> tuple[DescribedSite, str, Board] | None:
        site, colon, name = key.partition(_COLON)
        live = self._sites.find_site(site) if colon else None
        board = None if live is None else live.description.boards.get(name)
        if live is None or board is None or not _sees_described(who, live, board):
            return None
        return live, name, board

    async def _detail_of(
        self, kept: KeptBoard, number: int | None, request: Request
    ) -> BoardDetail:
        wanted = kept.number if number is None else number
        board = await self._boards.read_version(kept, wanted)
        if board is None:
            raise ApiProblem(404, "unknown", "there is no such version")
        row = _row_of(kept, who_of(request))
        return BoardDetail(row=row, number=wanted, board=_shape_of(board))

    def _append_record(self, request: Request, kind: str, message: str, site: str) -> None:
        self._audit.append_record(
            kind, who=who_of(request).name, address=address_of(request), site=site, message=message
        )


def _sees_described(who: Who, live: DescribedSite, board: Board) -> bool:
    if board.share is BoardOpenness.PUBLIC:
        return sees_site(who.grants, live.description)
    # Nobody owns it: a number that no account has.
    return sees_board(who, BoardSubject(0, BoardShare.VIEW, "", live.name))


def _row_of(kept: KeptBoard, who: Who) -> BoardRow:
    subject = kept.subject
    return BoardRow(
        key=kept.key,
        name=kept.name,
        site=subject.site,
        kind=kept.kind,
        described=False,
        owner=kept.owner,
        share=subject.share,
        role=subject.role,
        number=kept.number,
        tiles=kept.tiles,
        changed_us=kept.changed_us,
        may_change=may_change(who, subject),
        may_share=may_share(who, subject, BoardShare.VIEW, ""),
    )


def _row_of_described(live: DescribedSite, name: str, board: Board) -> BoardRow:
    return BoardRow(
        key=f"{live.name}{_COLON}{name}",
        name=board.name,
        site=live.name,
        kind="" if board.kind is None else board.kind.value,
        described=True,
        owner="",
        share=BoardShare(board.share.value),
        role="",
        number=0,
        tiles=len(board.tiles),
        changed_us=0,
        may_change=False,
        may_share=False,
    )


def _board_of(shape: BoardShape) -> Board:
    """Make a board of what was sent.

    Raises:
        ApiProblem: 422, it does not fit together.

    """
    plain = shape.model_dump(mode="json")
    plain["kind"] = plain["kind"] or None
    try:
        board = convert_board(plain)
    except DescriptionError as error:
        raise ApiProblem(422, "invalid", str(error)) from error
    for finding in board_findings("$", board):
        raise ApiProblem(422, "invalid", str(finding))
    return board


def _shape_of(board: Board) -> BoardShape:
    return BoardShape(
        name=board.name,
        note=board.note,
        site=board.site,
        kind=board.kind or "",
        device=board.device,
        tiles=list(_tile_shapes(board)),
    )


def _tile_shapes(board: Board) -> Iterator[BoardTileShape]:
    taken = {tile.id for tile in board.tiles}
    free = (name for name in (f"t{number}" for number in range(1, 1000)) if name not in taken)
    for tile in board.tiles:
        yield BoardTileShape(
            id=tile.id or next(free),
            type=tile.type,
            title=tile.title,
            settings={
                key: list(value) if isinstance(value, tuple) else value
                for key, value in tile.settings.items()
            },
            desktop=_place_of(tile.desktop),
            phone=_place_of(tile.phone),
        )


def _place_of(place: TilePlace | None) -> BoardPlaceShape | None:
    return None if place is None else BoardPlaceShape(**msgspec.structs.asdict(place))
