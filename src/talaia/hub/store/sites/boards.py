"""Boards that people made, and every version of each."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, insert, select, update

from talaia.hub.auth.board_access import BoardShare, BoardSubject
from talaia.hub.store.board_tables import board_versions, boards
from talaia.hub.store.tables import users
from talaia.model.boards.board_file import read_board_json, write_board_json

if TYPE_CHECKING:
    from sqlalchemy import Row, Select
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database
    from talaia.model.boards.board import Board

__all__ = ["MOST_BOARDS", "MOST_VERSIONS", "BoardVersion", "Boards", "KeptBoard"]

# Of one person.
MOST_BOARDS = 200
# Of one board; the oldest go.
MOST_VERSIONS = 100
_LONGEST = 200


class KeptBoard(NamedTuple):
    """A board as a list has it."""

    id: int
    key: str
    owner: str
    subject: BoardSubject
    name: str
    kind: str
    number: int
    tiles: int
    changed_us: int


class BoardVersion(NamedTuple):
    """A version of a board: when it was saved, by whom, and what they said of it."""

    number: int
    time_us: int
    who: str
    note: str


class Boards:
    """Rows of boards."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps what is saved."""
        self._database = database
        self._clock = clock

    async def list_boards(self) -> list[KeptBoard]:
        """List every board, the one that was changed last first."""
        query = _select_boards().order_by(boards.c.changed_us.desc(), boards.c.id.desc())
        async with self._database.read() as connection:
            return [_board_of(row) for row in await connection.execute(query)]

    async def find_board(self, key: str) -> KeptBoard | None:
        """Find a board by the key of its address."""
        async with self._database.read() as connection:
            return await _find(connection, key)

    async def read_version(self, board: KeptBoard, number: int) -> Board | None:
        """Give a version of a board; None when there is none such."""
        table = board_versions
        query = select(table.c.text).where(table.c.board_id == board.id, table.c.number == number)
        async with self._database.read() as connection:
            text = (await connection.execute(query)).scalar()
        return None if text is None else read_board_json(text)

    async def list_versions(self, board: KeptBoard) -> list[BoardVersion]:
        """List a board's versions, the newest first."""
        columns = (board_versions.c[name] for name in BoardVersion._fields)
        query = (
            select(*columns)
            .where(board_versions.c.board_id == board.id)
            .order_by(board_versions.c.number.desc())
        )
        async with self._database.read() as connection:
            return [BoardVersion(*row) for row in await connection.execute(query)]

    async def add_board(self, board: Board, owner: int, who: str, note: str) -> str | None:
        """Keep a new board, seen by its owner alone; give its key.

        Returns:
            None when its owner has as many as may be.

        """
        key = secrets.token_hex(8)
        now = self._now_us()
        async with self._database.write() as connection:
            count = select(func.count()).where(boards.c.owner_id == owner)
            if int((await connection.execute(count)).scalar_one()) >= MOST_BOARDS:
                return None
            added = await connection.execute(
                insert(boards).values(
                    board_key=key,
                    owner_id=owner,
                    share=BoardShare.OWN.value,
                    role="",
                    number=1,
                    changed_us=now,
                    **_columns_of(board),
                )
            )
            number = int(added.inserted_primary_key[0]) if added.inserted_primary_key else 0
            saved = BoardVersion(1, now, who[:_LONGEST], note[:_LONGEST])
            await _insert_version(connection, number, saved, board)
        return key

    async def save_version(
        self, kept: KeptBoard, board: Board, *, base: int, who: str, note: str
    ) -> int | None:
        """Keep another version of a board; give its number.

        Returns:
            None when its newest version is not ``base`` any more: somebody else was faster.

        """
        now = self._now_us()
        async with self._database.write() as connection:
            found = await _find(connection, kept.key)
            if found is None or found.number != base:
                return None
            number = base + 1
            saved = BoardVersion(number, now, who[:_LONGEST], note[:_LONGEST])
            await _insert_version(connection, kept.id, saved, board)
            await connection.execute(
                update(boards)
                .where(boards.c.id == kept.id)
                .values(number=number, changed_us=now, **_columns_of(board))
            )
            await connection.execute(
                delete(board_versions).where(
                    board_versions.c.board_id == kept.id,
                    board_versions.c.number <= number - MOST_VERSIONS,
                )
            )
        return number

    async def share_board(self, board: KeptBoard, share: BoardShare, role: str) -> None:
        """Open a board to others, or to nobody else."""
        async with self._database.write() as connection:
            await connection.execute(
                update(boards)
                .where(boards.c.id == board.id)
                .values(share=share.value, role=role if share is BoardShare.ROLE else "")
            )

    async def remove_board(self, board: KeptBoard) -> None:
        """Remove a board with all its versions."""
        async with self._database.write() as connection:
            # By hand: SQLite follows foreign keys only where it is told to.
            await connection.execute(
                delete(board_versions).where(board_versions.c.board_id == board.id)
            )
            await connection.execute(delete(boards).where(boards.c.id == board.id))

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _select_boards() -> Select[tuple[object, ...]]:
    return select(*boards.c, users.c.name.label("owner")).join(
        users, users.c.id == boards.c.owner_id
    )


async def _find(connection: AsyncConnection, key: str) -> KeptBoard | None:
    row = (await connection.execute(_select_boards().where(boards.c.board_key == key))).first()
    return None if row is None else _board_of(row)


async def _insert_version(
    connection: AsyncConnection, number: int, saved: BoardVersion, board: Board
) -> None:
    await connection.execute(
        insert(board_versions).values(
            board_id=number, text=write_board_json(board), **saved._asdict()
        )
    )


def _columns_of(board: Board) -> dict[str, object]:
    return {
        "name": board.name,
        "site": board.site,
        "kind": "" if board.kind is None else board.kind.value,
        "tiles": len(board.tiles),
    }


def _board_of(row: Row[tuple[object, ...]]) -> KeptBoard:
    return KeptBoard(
        id=row.id,
        key=row.board_key,
        owner=row.owner,
        subject=BoardSubject(row.owner_id, BoardShare(row.share), row.role, row.site),
        name=row.name,
        kind=row.kind,
        number=row.number,
        tiles=row.tiles,
        changed_us=row.changed_us,
    )
