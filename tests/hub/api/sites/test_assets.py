"""Meshes over a hub that really serves: who gets them, and that nothing else is ever read."""

from __future__ import annotations

from dataclasses import replace

import pytest

MESH = b"solid body\nendsolid body\n"
BODY = "package://base/body.stl"
ASSETS = "/api/sites/agv/assets"
# Written so that a client leaves it as it is; the hub decodes it.
ABOVE = "/api/sites/%2e%2e/assets"


@pytest.fixture
def settings(settings, tmp_path):
    folder = tmp_path / "assets"
    for site in ("agv", "moon"):
        (folder / site / "base").mkdir(parents=True)
    (folder / "agv" / "base" / "body.stl").write_bytes(MESH)
    (folder / "agv" / "base" / "keys.pem").write_text("secret")
    (folder / "moon" / "base" / "other.stl").write_text("secret")
    (tmp_path / "above.stl").write_text("secret")
    (folder / "agv" / "base" / "link.stl").symlink_to(tmp_path / "above.stl")
    return replace(settings, assets=folder)


async def test_a_mesh_goes_to_who_may_view_and_is_sent_again_only_when_it_is_another(
    hub, gateway, tmp_path
) -> None:
    operator = await hub.client("operator")
    answer = await operator.get(ASSETS, params={"uri": BODY})
    assert (answer.status_code, answer.content) == (200, MESH)
    # No page: whatever stands in it, a browser does not run it.
    assert answer.headers["content-type"] == "application/octet-stream"
    assert answer.headers["content-disposition"] == "attachment"
    known = {"If-None-Match": answer.headers["etag"]}
    again = await operator.get(ASSETS, params={"uri": BODY}, headers=known)
    assert (again.status_code, again.content) == (304, b"")
    (tmp_path / "assets" / "agv" / "base" / "body.stl").write_bytes(MESH + b" ")
    changed = await operator.get(ASSETS, params={"uri": BODY}, headers=known)
    assert (changed.status_code, changed.content) == (200, MESH + b" ")
    # A guest sees a public signal, which is no right to view; a stranger sees nothing.
    guest = await (await hub.client("guest")).get(ASSETS, params={"uri": BODY})
    stranger = await (await hub.client()).get(ASSETS, params={"uri": BODY})
    assert (guest.status_code, stranger.status_code) == (404, 401)


async def test_nothing_but_the_sites_own_meshes_is_sent(hub, gateway) -> None:
    # Who may see all: only the folder bounds what an admin gets.
    admin = await hub.client("admin")
    asked = [
        (ASSETS, "package://base/none.stl"),
        (ASSETS, "package://base/keys.pem"),
        (ASSETS, "package://base/link.stl"),
        (ASSETS, "package://base/../../moon/base/other.stl"),
        (ASSETS, "package://base/%2e%2e/%2e%2e/moon/base/other.stl"),
        (ASSETS, "file:///etc/passwd"),
        (ASSETS, "http://127.0.0.1/body.stl"),
        (ABOVE, "package://above.stl"),
        (ABOVE, "package://assets/agv/base/body.stl"),
        ("/api/sites/%2e/assets", "package://agv/base/body.stl"),
        ("/api/sites/agv%2fbase/assets", "package://body.stl"),
        ("/api/sites/none/assets", BODY),
    ]
    for path, uri in asked:
        answer = await admin.get(path, params={"uri": uri})
        assert (answer.status_code, b"secret" in answer.content) == (404, False), (path, uri)
    assert (await admin.get(ASSETS)).status_code == 422
    assert (await admin.get(ASSETS, params={"uri": BODY})).content == MESH
