"""Films what comes into sight, where the description wants a clip of it. Event loop only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.model.derived_signals import clips_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.site import Site
    from talaia.objects.camera_objects import SightingNews

__all__ = ["ClipFilms", "Films"]

# What is in sight and has its clip; more is nothing that a person could follow.
_MOST_OPEN = 500


class Films(Protocol):
    """Whoever films; see `talaia.gateway.recording.film_recorder.FilmRecorder`."""

    def begin_film(self, who: str, why: str, for_s: float, stream: str = "") -> None:
        """Film a camera from what is held of it on."""
        ...


class ClipFilms:
    """Takes news of sightings before they go their way, and films each once."""

    def __init__(
        self, site: Site, films: Films | None, on_news: Callable[[str, SightingNews], None]
    ) -> None:
        """Hand all news on to ``on_news``; film nothing where there is nobody who could."""
        self._films = films
        self._on_news = on_news
        self._clips = clips_of(site)
        # Camera, class and begin of what is in sight: told again and again until it is over.
        self._filmed: dict[tuple[str, str, int], None] = {}

    def redescribe(self, site: Site) -> None:
        """Film by another description."""
        self._clips = clips_of(site)

    def report_sighting(self, stream: str, news: SightingNews) -> None:
        """Take news of a sighting on a camera (``device/stream``)."""
        sighting = news.sighting
        key = (stream, sighting.label, sighting.began_us)
        clip = self._clips.get(stream)
        if sighting.ended_us is not None:
            self._filmed.pop(key, None)
        elif clip is not None and self._films is not None and key not in self._filmed:
            self._filmed[key] = None
            if len(self._filmed) > _MOST_OPEN:
                del self._filmed[next(iter(self._filmed))]
            self._films.begin_film("", f"{sighting.label} in sight", clip.after, stream)
        self._on_news(stream, news)
