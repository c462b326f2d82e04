"""What a site's description says of its nights. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.model.observing.plan import Instrument, PauseRules

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = ["ObservingNews", "filters_of", "instrument_of", "is_observatory", "pauses_of"]


class ObservingNews(Protocol):
    """Whoever tells a site's gateway what is asked of its nights."""

    def requests_changed(self, site: str) -> None:
        """Proposals or requests have changed; never waits."""
        ...


def is_observatory(site: Site) -> bool:
    """Tell whether a site observes by itself: without that nobody would act on a request."""
    return site.night is not None


def instrument_of(site: Site) -> Instrument:
    """Give how long its telescope takes for what stands between exposures."""
    return site.night.times if site.night is not None else Instrument()


def pauses_of(site: Site) -> PauseRules:
    """Give what its night does between exposures beside that."""
    return site.night.pauses if site.night is not None else PauseRules()


def filters_of(site: Site) -> tuple[str, ...] | None:
    """Name the filters that can be asked for; None: there is no wheel, so any name is a note."""
    night = site.night
    return tuple(night.filter.filters) if night is not None and night.filter is not None else None
