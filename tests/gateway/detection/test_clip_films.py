"""A film is begun once for each thing that comes into sight."""

from __future__ import annotations

import msgspec

from talaia.gateway.detection.clip_films import ClipFilms
from talaia.model.checks.site_checks import check_site
from talaia.model.derived_signals import clip_lengths
from talaia.model.yaml_text.load import load_site
from talaia.objects.camera_objects import SightingNews
from talaia.objects.sightings import ObjectSighting

FRONT = "camera/front"
TEXT = """
talaia: 1
site: hall
name: Hall
ros2: {}
recording: {}
devices:
  camera:
    name: Camera
    streams:
      front:
        name: Front
        source: {topic: /images, type: sensor_msgs/msg/Image}
        detect: {classes: [person], clip: {before: 3, after: 4}}
"""


class Filmed:
    """Notes what is to be filmed."""

    def __init__(self) -> None:
        """Film nothing yet."""
        self.begun: list[tuple[str, float, str]] = []

    def begin_film(self, who: str, why: str, for_s: float, stream: str = "") -> None:
        assert who == ""
        self.begun.append((why, for_s, stream))


def news(began_us: int, ended_us: int | None = None) -> SightingNews:
    return SightingNews(ObjectSighting("person", 1, 0.9, began_us, ended_us), b"")


def test_each_sighting_is_filmed_once_however_often_it_is_told_and_goes_its_way():
    filmed, told = Filmed(), []
    films = ClipFilms(load_site(TEXT), filmed, lambda stream, one: told.append((stream, one)))
    for one in (news(1), news(1), news(2), news(1, 5), news(2, 6), news(7)):
        films.report_sighting(FRONT, one)
    assert filmed.begun == [("person in sight", 4.0, FRONT)] * 3
    assert len(told) == 6
    films.report_sighting("camera/rear", news(1))
    assert len(filmed.begun) == 3


def test_what_was_over_when_it_was_told_first_is_not_filmed():
    filmed = Filmed()
    ClipFilms(load_site(TEXT), filmed, lambda *_: None).report_sighting(FRONT, news(1, 2))
    assert filmed.begun == []


def test_a_clip_wants_recordings_and_a_gateway_that_looks_itself():
    site = load_site(TEXT)
    assert clip_lengths(site) == {FRONT: 3.0}
    silent = msgspec.structs.replace(site, recording=None)
    assert clip_lengths(silent) == {}
    at = "$.devices.camera.streams.front.detect.clip"
    assert [found.where for found in check_site(silent)] == [at]
    far = load_site(TEXT.replace("{classes", "{at: hub, classes"))
    assert at in [found.where for found in check_site(far)]
    assert list(check_site(site)) == []
