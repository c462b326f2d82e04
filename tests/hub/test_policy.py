"""The policy table: a line for everything, and each line against each kind of person."""

from typing import get_args

import pytest
from fastapi.routing import iter_route_contexts

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.policy import (
    CLIENT_SOCKETS,
    FROM_BROWSER,
    FROM_GATEWAY,
    ROUTES,
    SOCKETS,
    TO_BROWSER,
    TO_GATEWAY,
    AccessNeed,
    allows,
    need_of_message,
    need_of_route,
)
from talaia.model.yaml_text.load import load_site
from talaia.wire import browser, frames
from talaia.wire.message import Message

SITE = load_site(
    """
talaia: 1
site: farm
name: Farm
ros2: {}
devices:
  gate:
    name: Gate
    visibility: public
    signals: {angle: {name: Angle, source: {topic: /a, type: std_msgs/msg/Float64}}}
  barn: {name: Barn}
"""
)
PEOPLE = {
    "nobody": None,
    "guest": Grants(),
    "barn operator": Grants(frozenset({Permission(Right.USE, "farm", "barn")})),
    "operator": Grants(frozenset({Permission(Right.USE)})),
    "elsewhere": Grants(frozenset({Permission(Right.ADMIN, "moon")})),
    # Each right of the night is a right of its own.
    "requester": Grants(frozenset({Permission(Right.REQUEST)})),
    "approver": Grants(frozenset({Permission(Right.APPROVE)})),
    "night assistant": Grants(frozenset({Permission(Right.ARM)})),
    "night watch": Grants(frozenset({Permission(Right.UNBLURRED, "farm", "gate")})),
    "admin": Grants(frozenset({Permission(Right.ADMIN)})),
}
# Who meets a need: about the public gate, about the barn, about the whole site, about nothing.
EVERYONE = set(PEOPLE)
SIGNED_IN = EVERYONE - {"nobody"}
MEETS = {
    AccessNeed.OPEN: (EVERYONE, EVERYONE, EVERYONE, EVERYONE),
    AccessNeed.SESSION: (SIGNED_IN, SIGNED_IN, SIGNED_IN, SIGNED_IN),
    AccessNeed.OWN: (SIGNED_IN, SIGNED_IN, SIGNED_IN, SIGNED_IN),
    AccessNeed.SEE: (SIGNED_IN, {"barn operator", "operator", "admin"}, SIGNED_IN, set()),
    AccessNeed.VIEW: (
        {"operator", "admin"},
        {"barn operator", "operator", "admin"},
        {"operator", "admin"},
        set(),
    ),
    AccessNeed.USE: (
        {"operator", "admin"},
        {"barn operator", "operator", "admin"},
        {"operator", "admin"},
        set(),
    ),
    AccessNeed.ADMIN: ({"admin"}, {"admin"}, {"admin"}, {"admin"}),
    AccessNeed.REQUEST: (*({"requester", "admin"} for _ in range(3)), set()),
    AccessNeed.APPROVE: (*({"approver", "admin"} for _ in range(3)), set()),
    AccessNeed.ARM: (*({"night assistant", "admin"} for _ in range(3)), set()),
    AccessNeed.UNBLURRED: ({"night watch", "admin"}, {"admin"}, {"admin"}, set()),
    AccessNeed.GATEWAY: (set(), set(), set(), set()),
    # By a token of a client, which is asked for where the protocols are known.
    AccessNeed.CLIENT: (set(), set(), set(), set()),
    AccessNeed.NEVER: (set(), set(), set(), set()),
}
OBJECTS = ((SITE, "gate"), (SITE, "barn"), (SITE, ""), (None, ""))


def members(*unions: object) -> set[type]:
    return {member for union in unions for member in (get_args(union) or (union,))}


def test_every_route_of_the_application_has_a_line_and_no_line_is_left_over(hub_parts) -> None:
    found = {
        (method, context.path)
        for context in iter_route_contexts(hub_parts.app.router.routes)
        for method in (context.methods or ())
        if method != "HEAD"
    }
    assert found == set(ROUTES)


def test_every_socket_has_a_line_and_no_line_is_left_over(hub_parts) -> None:
    found = {
        route.path
        for route in hub_parts.app.router.routes
        if type(route).__name__ == "APIWebSocketRoute"
    }
    assert found == {*SOCKETS, *CLIENT_SOCKETS}


@pytest.mark.parametrize(
    ("table", "unions"),
    [
        (
            FROM_BROWSER,
            (browser.FromBrowser, browser.MediaFromBrowser, browser.TopicFromBrowser),
        ),
        (TO_BROWSER, (browser.ToBrowser, browser.MediaToBrowser, browser.TopicToBrowser)),
        (FROM_GATEWAY, (frames.FromGateway, frames.MediaFromGateway, frames.FilesFromGateway)),
        (TO_GATEWAY, (frames.FromHub, frames.MediaFromHub, frames.FilesFromHub)),
    ],
)
def test_every_message_has_a_line_and_no_line_is_left_over(table, unions) -> None:
    assert members(*unions) == set(table)


def test_what_has_no_line_is_denied_to_everyone() -> None:
    class Strange(Message, frozen=True, tag="strange"):
        pass

    assert need_of_message(FROM_BROWSER, Strange()) is AccessNeed.NEVER
    assert need_of_route("POST", "/api/sites") is AccessNeed.NEVER


@pytest.mark.parametrize("need", AccessNeed)
@pytest.mark.parametrize("at", range(len(OBJECTS)))
def test_each_need_is_met_by_exactly_these(need, at) -> None:
    site, device = OBJECTS[at]
    met = {name for name, grants in PEOPLE.items() if allows(need, grants, site, device)}
    assert met == MEETS[need][at]


def test_device_that_is_not_there_is_nobodys() -> None:
    for need in (AccessNeed.SEE, AccessNeed.VIEW, AccessNeed.USE, AccessNeed.ADMIN):
        assert not allows(need, PEOPLE["admin"], SITE, "cellar")
