"""What the pages of an observatory need of the hub: place, rules, roofs, and names of the sky."""

from pathlib import Path

import pytest
import pytest_asyncio

from talaia.hub.api.sites import sky_field, sky_names
from talaia.imaging.tangent_plane import angular_distance

OBSERVATORY = (Path(__file__).parents[4] / "examples" / "observatory" / "site.yaml").read_text()
pytestmark = pytest.mark.asyncio(loop_scope="module")
DESCRIPTION = OBSERVATORY.replace("site: observatory", "site: agv")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def observatory(shared_hub):
    """A gateway with the observatory's description, at the site that the test hub knows."""
    gateway = await shared_hub.gateway()
    await gateway.hello(DESCRIPTION)
    return gateway


async def described(hub, name: str) -> dict:
    return (await (await hub.client(name)).get("/api/sites/agv")).json()


async def test_whoever_may_view_the_site_is_told_where_it_is(shared_hub, observatory) -> None:
    place = (await described(shared_hub, "operator"))["place"]
    assert place == {"latitude": 42.0517, "longitude": 0.7297, "elevation": 1568.0}
    assert (await described(shared_hub, "guest"))["place"] is None


async def test_a_rule_comes_with_its_numbers(shared_hub, observatory) -> None:
    rules = {each["id"]: each for each in (await described(shared_hub, "operator"))["rules"]}
    assert set(rules) == {"rain", "weather", "on_site", "daylight"}
    wind = rules["weather"]["conditions"][0]
    assert wind["lasting"] == 2
    assert wind["limits"][0]["signal"] == "weather/wind"
    assert (wind["limits"][0]["above"], wind["limits"][0]["until_below"]) == (45, 35)
    assert rules["rain"]["conditions"][0]["limits"][0]["states"] == ["wet"]
    assert (rules["weather"]["hidden"], rules["weather"]["dwell"]) == (0, 120)
    assert "camera/expose" in rules["rain"]["targets"]


async def test_a_guest_sees_no_limit_of_what_is_not_public(shared_hub, observatory) -> None:
    rules = {each["id"]: each for each in (await described(shared_hub, "guest"))["rules"]}
    signals = {
        limit["signal"]
        for rule in rules.values()
        for condition in rule["conditions"]
        for limit in condition["limits"]
    }
    assert "weather/wind" in signals
    assert "weather/gust" not in signals
    assert rules["weather"]["hidden"] == 2
    assert rules["rain"]["targets"] == ["dome/open"]


async def test_a_roof_says_by_which_sensors_it_is_closed(shared_hub, observatory) -> None:
    (roof,) = (await described(shared_hub, "operator"))["enclosures"]
    assert [each["signal"] for each in roof["closed"]] == [
        "dome/closed",
        "dome/shutter",
        "dome/position",
    ]
    assert (roof["close"], roof["stop"], roof["unsafe"]) == (
        "dome/close",
        "dome/stop",
        ["rain", "weather", "daylight"],
    )
    # One of its sensors is not public: who sees only half of the proof is told of none.
    assert (await described(shared_hub, "guest"))["enclosures"] == []


async def test_a_telescope_says_what_points_it_and_where_it_may_not(
    shared_hub, observatory
) -> None:
    devices = {each["id"]: each for each in (await described(shared_hub, "operator"))["devices"]}
    pointing = devices["telescope"]["pointing"]
    assert (pointing["horizon"], pointing["sun"]) == (15, 30)
    assert pointing["commands"][0] == {
        "command": "goto",
        "ra": "ra",
        "dec": "dec",
        "alt": "",
        "az": "",
    }
    assert devices["dome"]["pointing"] is None


@pytest.mark.parametrize("name", ["M31", "ngc 224", "Andromeda Galaxy"])
async def test_a_galaxy_is_found_by_each_of_its_names(shared_hub, observatory, name: str) -> None:
    pytest.importorskip("pyongc")
    answer = await (await shared_hub.client("operator")).get(
        "/api/sites/agv/sky", params={"name": name}
    )
    found = answer.json()
    assert found["available"] is True
    best = found["objects"][0]
    assert (best["name"], best["constellation"], best["kind"]) == ("NGC0224", "And", "Galaxy")
    assert best["ra_deg"] == pytest.approx(10.6848, abs=0.001)
    assert best["dec_deg"] == pytest.approx(41.2691, abs=0.001)


async def test_a_southern_declination_keeps_its_sign(shared_hub, observatory) -> None:
    pytest.importorskip("pyongc")
    (orion,) = sky_names.look_up("M42")
    assert orion.dec_deg == pytest.approx(-5.3897, abs=0.001)


@pytest.mark.parametrize("name", ["%", "_", "no such thing"])
async def test_what_nobody_calls_anything_is_not_found(shared_hub, observatory, name: str) -> None:
    answer = await (await shared_hub.client("operator")).get(
        "/api/sites/agv/sky", params={"name": name}
    )
    assert answer.json()["objects"] == []


async def test_without_the_catalogue_the_hub_says_so(shared_hub, observatory, monkeypatch) -> None:
    monkeypatch.setattr(sky_names, "_load_catalogue", lambda: None)
    answer = await (await shared_hub.client("operator")).get(
        "/api/sites/agv/sky", params={"name": "M31"}
    )
    assert answer.json() == {"available": False, "objects": []}


async def test_a_piece_of_the_sky_has_its_stars_and_the_outline_of_a_galaxy(
    shared_hub, observatory
) -> None:
    pytest.importorskip("pyongc")
    answer = await (await shared_hub.client("operator")).get(
        "/api/sites/agv/sky/field", params={"ra": 10.68, "dec": 41.27, "radius": 2}
    )
    found = answer.json()
    galaxy = found["objects"][0]
    assert (galaxy["name"], galaxy["also"][0], galaxy["angle"]) == ("NGC0224", "M031", 35.0)
    assert galaxy["major"] == pytest.approx(2.96, abs=0.01)
    # nu Andromedae, the brightest there, comes first.
    magnitudes = [star["magnitude"] for star in found["stars"]]
    assert magnitudes == sorted(magnitudes)
    assert magnitudes[0] == pytest.approx(4.5, abs=0.1)


@pytest.fixture(scope="module")
def whole_sky() -> list[sky_names.CatalogObject]:
    """All that is wide enough: the package reads each with questions of its own, for seconds."""
    pytest.importorskip("pyongc")
    return sky_names.objects_between((0.0, 360.0), (-90.0, 90.0), 2.5)


@pytest.mark.parametrize(
    ("ra", "dec"), [(0.05, 15.0), (359.95, 15.0), (0.5, 68.0), (200.0, 89.9), (3.0, -89)]
)
async def test_a_piece_of_the_sky_is_whole_at_the_seam_and_at_the_poles(
    ra: float, dec: float, whole_sky: list[sky_names.CatalogObject]
) -> None:
    stars, objects = sky_field.look_around(ra, dec, 5.0)
    everything = [
        found
        for found in whole_sky
        if angular_distance(ra, dec, found.ra_deg, found.dec_deg) <= 5.0
    ]
    assert {found.name for found in objects} == {found.name for found in everything}
    # Both sides of the seam, and all round the pole.
    reach = [(star.ra_deg - ra + 180.0) % 360.0 - 180.0 for star in stars]
    assert min(reach) < -2.0
    assert max(reach) > 2.0
