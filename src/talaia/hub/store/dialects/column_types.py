"""Types of columns that engines know by other names."""

from __future__ import annotations

from sqlalchemy import BigInteger, Integer, LargeBinary, String, Text
from sqlalchemy.dialects import mysql

__all__ = ["EXACT_NAME", "LONG_BYTES", "LONG_TEXT", "PICTURE_BYTES", "ROW_ID", "UNICODE_TEXT"]

_MARIADB = ("mysql", "mariadb")
# SQLite numbers rows by itself only in a column of the type INTEGER.
ROW_ID = BigInteger().with_variant(Integer, "sqlite")
# MariaDB's TEXT ends at 64 KiB unless it is told a length; PostgreSQL's takes none.
LONG_TEXT = Text(4 * 1024 * 1024).with_variant(Text(), "postgresql")
# MariaDB compares texts without regard to case unless told otherwise.
EXACT_NAME = String(200).with_variant(
    mysql.VARCHAR(200, charset="utf8mb4", collation="utf8mb4_bin"), *_MARIADB
)
# The default of a server may be a character set that holds less.
UNICODE_TEXT = Text().with_variant(mysql.TEXT(charset="utf8mb4"), *_MARIADB)
# MariaDB's BLOB ends at 64 KiB.
LONG_BYTES = LargeBinary().with_variant(mysql.LONGBLOB(), *_MARIADB)
PICTURE_BYTES = LargeBinary().with_variant(mysql.MEDIUMBLOB(), *_MARIADB)
