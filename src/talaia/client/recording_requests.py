"""A site's recordings: begun, ended, listed and taken away."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.client.errors import HubNotReached, NotFound, RequestRefused
from talaia.client.history_reading import write_body
from talaia.client.http_requests import quote_segment
from talaia.client.values import RecordingOverview

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.client.hub_api import HubApi
    from talaia.client.values import RecordedFile, RecorderInfo

__all__ = ["ask_recorder", "download_recording", "overview_of", "wait_complete"]

# How long a gateway may take to begin or end, and how often is looked (s).
_ANSWER_S = 15.0
_LOOK_S = 0.25


async def overview_of(api: HubApi, site: str) -> RecordingOverview:
    """List a site's recordings, and tell how its recorder stands.

    Raises:
        ClientError: the hub cannot be asked, or says no.

    """
    return await api.get_json(RecordingOverview, _path_of(site), needs=f"the right view of {site}")


async def ask_recorder(api: HubApi, site: str, *, on: bool, why: str, stream: str) -> RecorderInfo:
    """Let a gateway begin or end a recording, or the film of one camera; wait until it has.

    Raises:
        RequestRefused: the gateway cannot, with its reason.
        HubNotReached: it has not said anything.
        ClientError: the hub cannot be asked, or says no.

    """
    # Of one that failed before this one was asked for.
    former = (await overview_of(api, site)).recorder.problem
    problem = ""
    body = {"on": on, "why": why, "stream": stream}
    await api.send_json("POST", _path_of(site), body, needs=f"the right use of {site}")
    try:
        async with asyncio.timeout(_ANSWER_S):
            while True:
                recorder = (await overview_of(api, site)).recorder
                if on == (stream in recorder.filming if stream else recorder.on):
                    return recorder
                problem = recorder.problem
                if on and problem not in {"", former}:
                    raise RequestRefused("recorder", problem)
                await asyncio.sleep(_LOOK_S)
    except TimeoutError as error:
        # The same trouble as before, perhaps.
        if on and problem:
            raise RequestRefused("recorder", problem) from error
        what = "begun" if on else "ended"
        raise HubNotReached(
            f"the gateway of {site} has not {what} within {_ANSWER_S:g} s; the site's logbook may"
            " say why"
        ) from error


async def wait_complete(
    api: HubApi, site: str, recording: str, *, timeout_s: float
) -> RecordedFile:
    """Wait until the whole of a recording is at the hub.

    Raises:
        RequestRefused: it failed, or is not whole after so long.
        ClientError: the hub cannot be asked, or says no.

    """
    note = "it is not listed"
    with_end = asyncio.timeout(timeout_s)
    try:
        async with with_end:
            while True:
                for found in (await overview_of(api, site)).recordings:
                    if found.id != recording:
                        continue
                    if found.state == "complete":
                        return found
                    note = found.note or f"{found.have} of {found.size} bytes are at the hub"
                    if found.state == "failed":
                        raise RequestRefused("failed", f"recording {recording} failed: {note}")
                await asyncio.sleep(2 * _LOOK_S)
    except TimeoutError as error:
        raise RequestRefused(
            "incomplete", f"recording {recording} is not whole after {timeout_s:g} s: {note}"
        ) from error


async def download_recording(
    api: HubApi,
    site: str,
    recording: str,
    *,
    path: Path,
    report: Callable[[int], None] | None,
) -> int:
    """Save a recording as a file; give its size in bytes.

    Raises:
        NotFound: there is none such.
        HistoryCut: the connection was lost before its end.
        ClientError: the hub cannot be asked, or says no.

    """
    for found in (await overview_of(api, site)).recordings:
        if found.id == recording:
            break
    else:
        raise NotFound("unknown", f"there is no recording {recording!r} of {site}")

    def save() -> int:
        target = f"{_path_of(site)}/{quote_segment(recording)}/file"
        with api.requests.open_stream(target, needs=f"the right view of {site}") as stream:
            return write_body(stream, path, size=found.size, report=report)

    return await api.read_again(save)


def _path_of(site: str) -> str:
    return f"/api/sites/{quote_segment(site)}/recordings"
