"""How the API says no: what is missing at the hub, in a sentence of its own."""

import httpx
import pytest
from fastapi import FastAPI

from talaia.hub.api.problems import answer_problems
from talaia.hub.errors import LibraryMissing

pytestmark = pytest.mark.pure


async def test_what_needs_an_extra_is_answered_with_the_extra() -> None:
    app = FastAPI()
    answer_problems(app)

    @app.get("/file")
    def file() -> None:
        raise LibraryMissing("files need 'pyarrow'", "run: pip install 'talaia[arrow]'")

    transport = httpx.ASGITransport(app)
    async with httpx.AsyncClient(transport=transport, base_url="https://hub") as client:
        answer = await client.get("/file")
    assert answer.status_code == 501
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json() == {
        "code": "not_installed",
        "message": "files need 'pyarrow'; run: pip install 'talaia[arrow]'",
    }
