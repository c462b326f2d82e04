"""The main hub knows what sites of others are, for what is done once for all."""

from __future__ import annotations

from patience import until_answered

from talaia.hub.sharding.plan import MAIN

from .two_shards import AGV, LAB, description_of

BOARDS = """
boards:
  wall:
    name: Wall
    share: public
    tiles:
      - {type: value, settings: {signal: power/voltage}, desktop: {x: 0, y: 0, w: 3, h: 2}}
"""


async def until_known(shards, site: str, words: str = "") -> None:
    """Wait until the main hub knows a site, by words of its description."""

    async def is_known() -> bool:
        found = shards.main.hub.core.known_sites.find_site(site)
        return found is not None and words in repr(found.description)

    await until_answered(is_known)


async def test_the_main_hub_lists_boards_and_units_of_all_sites(shards) -> None:
    for site in (AGV, LAB):
        await shards.gateway(site, BOARDS)
    await until_known(shards, AGV)
    operator = await shards.main.client("operator")
    boards = (await operator.get("/api/boards")).json()["boards"]
    assert [board["key"] for board in boards] == ["agv:wall", "lab:wall"]
    assert (await operator.get("/api/boards/agv:wall")).json()["row"]["name"] == "Wall"
    units = (await operator.get("/api/me/units")).json()["units"]
    volts = next(unit for unit in units if unit["unit"] == "V")
    # By their names, which are the same.
    assert len(volts["sites"]) == 2


async def test_a_display_of_a_site_of_another_hub_is_made_at_the_main_one(shards) -> None:
    await shards.gateway(AGV)
    await until_known(shards, AGV)
    admin = await shards.main.client("admin")
    made = await admin.post("/api/displays", json={"name": "Wall", "sites": [AGV]})
    assert made.status_code == 200, made.text
    # It opens what it shows where that is.
    screen = await shards.east.client()
    cookie = {"Cookie": f"talaia={made.json()['token']}"}
    shown = (await screen.get("/api/sites", headers=cookie)).json()
    assert [site["site"] for site in shown] == [AGV]


async def test_an_admin_lets_somebody_drive_a_robot_of_another_hub(shards) -> None:
    await shards.gateway(AGV)
    await until_known(shards, AGV)
    admin = await shards.main.client("admin")
    people = (await admin.get("/api/people")).json()["people"]
    person = next(one["id"] for one in people if one["name"] == "operator")
    asked = {"person": person, "site": AGV, "device": "base", "allowed": True}
    assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204

    async def is_followed() -> bool:
        return shards.east.hub.client_protocols.protocols.may_drive(int(person), AGV, "base")

    await until_answered(is_followed)


async def test_a_description_that_changes_at_another_hub_is_followed(shards) -> None:
    gateway = await shards.gateway(AGV)
    await until_known(shards, AGV)
    await gateway.close()
    again = await shards.east.gateway(key=shards.keys[AGV])
    await again.hello(description_of(AGV).replace("House vehicle", "Garden vehicle"))
    await until_known(shards, AGV, "Garden vehicle")


async def test_the_main_hub_knows_sites_of_others_from_its_start(shards) -> None:
    for site in (AGV, LAB):
        await shards.gateway(site)
    await shards.end(MAIN)
    core = (await shards.start(MAIN)).hub.core
    assert [site.name for site in core.known_sites] == [AGV, LAB]
    assert [site.name for site in core.sites] == [LAB]


async def test_a_hub_of_all_sites_has_no_mirror(hub) -> None:
    core = hub.hub.core
    assert core.known_sites is core.sites
