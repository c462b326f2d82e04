"""Which commands a group of sites can be asked for."""

from __future__ import annotations

from msgspec.structs import replace

from talaia.hub.api.sites.shared_commands import list_shared_commands
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.model.site import Argument, ArgumentType, Command, Device, Site

EVERYWHERE = Grants(frozenset({Permission(Right.USE)}))
SPEED = Argument(type=ArgumentType.NUMBER, field="v", unit="m/s", minimum=0.0, maximum=2.0)


def site_with(name: str, argument: Argument = SPEED, *, confirm: bool = False) -> Site:
    command = Command(name="Cruise", target="/cruise", arguments={"v": argument}, confirm=confirm)
    return Site(
        talaia=1,
        site=name,
        name=name.upper(),
        devices={"base": Device(name="Base", kind="vehicle", commands={"cruise": command})},
    )


def shared(*sites: Site, grants: Grants = EVERYWHERE) -> list[tuple[list[str], list[str]]]:
    return [(one.sites, one.barred) for one in list_shared_commands(sites, grants)]


def test_sites_share_a_command_of_the_same_ids_and_arguments() -> None:
    assert shared(site_with("a"), site_with("b")) == [(["a", "b"], [])]


def test_arguments_in_another_unit_are_another_command() -> None:
    other = site_with("c", replace(SPEED, unit="km/h"))
    assert shared(site_with("a"), other, site_with("b")) == [(["a", "b"], []), (["c"], [])]


def test_limits_are_the_narrowest_and_whoever_asks_for_a_confirmation_gets_it() -> None:
    narrow = site_with("b", replace(SPEED, minimum=0.5, maximum=1.0), confirm=True)
    (one,) = list_shared_commands([site_with("a"), narrow], EVERYWHERE)
    (argument,) = one.command.arguments
    assert (argument.minimum, argument.maximum, one.command.confirm) == (0.5, 1.0, True)


def test_default_that_differs_is_nobodys() -> None:
    defaults = [site_with("a", replace(SPEED, default=0.1)), site_with("b")]
    assert list_shared_commands(defaults, EVERYWHERE)[0].command.arguments[0].default is None


def test_site_where_the_person_may_only_look_is_told_apart() -> None:
    some = Grants(frozenset({Permission(Right.USE, "a"), Permission(Right.VIEW, "b")}))
    sites = [site_with("a"), site_with("b"), site_with("hidden")]
    assert shared(*sites, grants=some) == [(["a"], ["b"])]


def test_command_that_the_person_may_use_nowhere_is_not_listed() -> None:
    viewer = Grants(frozenset({Permission(Right.VIEW)}))
    assert shared(site_with("a"), site_with("b"), grants=viewer) == []


async def test_operator_is_told_what_the_fleet_shares(hub, gateway) -> None:
    client = await hub.client("operator")
    answer = await client.get("/api/commands")
    assert answer.status_code == 200
    found = {(one["device"], one["command"]["id"]) for one in answer.json()["commands"]}
    assert ("base", "wander") in found
    (row,) = (await client.get("/api/sites")).json()
    assert row["stops"] == ["base"]
