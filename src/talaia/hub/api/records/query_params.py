"""What several routes allow in their questions, and say with what anybody could have made."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query

__all__ = ["STILL", "Time", "Word"]

# A moment (µs since 1970, UTC).
Time = Annotated[int, Query(ge=0, le=2**53)]
# No database holds a NUL.
Word = Annotated[str, Query(max_length=200, pattern=r"^[^\x00]*$")]
# A file may have been made by anyone who has a gateway's key: it must not act in a page.
STILL = {"Content-Security-Policy": "sandbox; default-src 'none'"}
