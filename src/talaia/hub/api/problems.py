"""How the API says no: a status, a word for programs and a sentence for people."""

from __future__ import annotations

import logging
from http import HTTPStatus
from typing import TYPE_CHECKING

from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from talaia.errors import TalaiaError
from talaia.hub.errors import FilesDown, LibraryMissing, StoreDown
from talaia.hub.history.errors import HistoryAway

if TYPE_CHECKING:
    from fastapi import FastAPI, Request, Response

__all__ = ["STORE_DOWN", "ApiProblem", "answer_problems", "problem_response"]

_LOG = logging.getLogger(__name__)
# For what the framework itself refuses.
_CODES = {400: "invalid", 404: "unknown", 405: "method", 413: "too_large", 422: "invalid"}


STORE_DOWN = "the hub's database does not answer; try again soon"


class ApiProblem(TalaiaError):
    """A request that is not done."""

    def __init__(self, status: int, code: str, message: str, retry_s: int = 0) -> None:
        """Answer with ``status``; ``retry_s`` tells when another try makes sense."""
        super().__init__(status, code, message)
        # Of the answer; a word for programs, which never changes; a sentence for people.
        self.status = status
        self.code = code
        self.message = message
        # Seconds; 0 says nothing of when.
        self.retry_s = retry_s

    def __str__(self) -> str:
        return self.message


def problem_response(status: int, code: str, message: str, retry_s: int = 0) -> Response:
    """Make the answer that says no."""
    headers = {"Retry-After": str(retry_s)} if retry_s else None
    return JSONResponse(
        {"code": code, "message": message},
        status,
        headers,
        media_type="application/problem+json",
    )


def answer_problems(app: FastAPI) -> None:
    """Let every error of ``app`` end in the same form."""
    app.add_exception_handler(ApiProblem, _handle_problem)
    # Of the framework itself: an unknown path, a method that is not there, a body that is no JSON.
    app.add_exception_handler(HTTPException, _handle_http)
    app.add_exception_handler(RequestValidationError, _handle_invalid)
    app.add_exception_handler(StoreDown, _handle_store)
    app.add_exception_handler(FilesDown, _handle_files)
    app.add_exception_handler(HistoryAway, _handle_history)
    app.add_exception_handler(LibraryMissing, _handle_library)
    app.add_exception_handler(Exception, _handle_failure)


async def _handle_problem(_request: Request, error: Exception) -> Response:
    if not isinstance(error, ApiProblem):
        raise error
    return problem_response(error.status, error.code, error.message, error.retry_s)


async def _handle_library(_request: Request, error: Exception) -> Response:
    return problem_response(501, "not_installed", str(error))


async def _handle_http(_request: Request, error: Exception) -> Response:
    status = error.status_code if isinstance(error, HTTPException) else 500
    return problem_response(status, _CODES.get(status, "failed"), HTTPStatus(status).phrase)


async def _handle_invalid(_request: Request, error: Exception) -> Response:
    if not isinstance(error, RequestValidationError):
        raise error
    # Only where and what: the input itself may be a password.
    said = [
        f"{'.'.join(str(step) for step in problem['loc'])}: {problem['msg']}"
        for problem in error.errors()
    ]
    # Cut: a list of a thousand items can be wrong at every one of them.
    return problem_response(422, "invalid", "; ".join(said)[:1000])


async def _handle_store(request: Request, error: Exception) -> Response:
    # Nobody's rights are known now, so nothing is done for anyone.
    _LOG.error("%s %s is refused: %s", request.method, request.url.path, error)
    return problem_response(503, "store", STORE_DOWN, 2)


async def _handle_files(_request: Request, error: Exception) -> Response:
    # Its loss is in the log once, however many ask.
    said = error.problem if isinstance(error, FilesDown) else str(error)
    return problem_response(503, "files", said, 2)


async def _handle_history(request: Request, error: Exception) -> Response:
    # Where it is, and why it is away, is for the log: addresses of servers are not for everybody.
    _LOG.error("%s %s is refused: %s", request.method, request.url.path, error)
    return problem_response(
        503, "history", "the history cannot be read now; nothing is lost, try again soon", 5
    )


async def _handle_failure(request: Request, error: Exception) -> Response:
    _LOG.error("%s %s failed", request.method, request.url.path, exc_info=error)
    # Not to the asker: a traceback can hold what is not theirs to see.
    return problem_response(500, "failed", "the hub failed; its log says more")
