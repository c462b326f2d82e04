"""The places in the sky that the pages' own astronomy is held to, held to astropy."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

VECTORS = json.loads((Path(__file__).parent / "sky_vectors.json").read_text())
CATALOGUE = {"m31": (10.68470833, 41.26875), "vega": (279.23473479, 38.78368896)}


@pytest.mark.parametrize("moment", VECTORS["moments"], ids=lambda moment: moment["utc"])
def test_astropy_says_what_stands_in_the_vectors(moment: dict[str, object]) -> None:
    pytest.importorskip("astropy")
    import numpy as np
    from astropy import units
    from astropy.coordinates import TETE, AltAz, EarthLocation, SkyCoord, get_body
    from astropy.time import Time
    from astropy.utils import data, iers

    iers.conf.auto_download = False
    iers.conf.auto_max_age = None
    data.conf.allow_internet = False
    place = VECTORS["place"]
    here = EarthLocation.from_geodetic(
        place["longitude"] * units.deg,
        place["latitude"] * units.deg,
        place["elevation"] * units.m,
    )
    when = Time(moment["utc"], scale="utc", location=here)
    horizon, of_date = AltAz(obstime=when, location=here), TETE(obstime=when, location=here)

    assert when.sidereal_time("mean").hour == pytest.approx(moment["sidereal_h"], abs=1e-4)
    sun, moon = get_body("sun", when, here), get_body("moon", when, here)
    for name, body in (("sun", sun), ("moon", moon)):
        seen = body.transform_to(horizon)
        assert [seen.alt.deg, seen.az.deg] == pytest.approx(moment[name], abs=0.01)
    apart = sun.separation(moon)
    angle = np.arctan2(sun.distance * np.sin(apart), moon.distance - sun.distance * np.cos(apart))
    assert float((1 + np.cos(angle)) / 2) == pytest.approx(moment["moon_lit"], abs=0.001)
    for name, (ra, dec) in CATALOGUE.items():
        star = SkyCoord(ra * units.deg, dec * units.deg)
        seen, dated = star.transform_to(horizon), star.transform_to(of_date)
        assert [seen.alt.deg, seen.az.deg] == pytest.approx(moment[name], abs=0.01)
        assert [dated.ra.hour, dated.dec.deg] == pytest.approx(moment[f"{name}_of_date"], abs=0.002)
