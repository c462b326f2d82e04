"""The adapters of one description for those of another, as few of them anew as possible."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.connection_scope import connection_names, scopes_of
from talaia.model.description_follower import DescriptionFollower

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.connectivity import DeviceReachability
    from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
    from talaia.gateway.ports import Adapter
    from talaia.gateway.samples.channel_numbering import ChannelNumbering
    from talaia.model.site import Site

__all__ = ["ConnectionExchange"]


class ConnectionExchange:
    """Knows what each connection serves, and exchanges those that are described otherwise."""

    def __init__(
        self,
        *,
        site: Site,
        numbering: ChannelNumbering,
        reachability: DeviceReachability,
        adapter: MultiAdapter,
        adapters: dict[str, tuple[Adapter, ConnectionStatus]],
        make: Callable[[ConnectionScope], tuple[Adapter, ConnectionStatus]],
    ) -> None:
        """Begin with the description that the adapters were made of.

        Args:
            site: that description.
            numbering: the numbers of channels.
            reachability: which devices can be reached.
            adapter: runs the adapters.
            adapters: each connection's adapter, by its name; kept up to date here.
            make: makes the adapter of a connection.

        """
        self._numbering = numbering
        self._reachability = reachability
        # Runs all adapters; is given the new ones last.
        self._adapter = adapter
        # Shared with others, so it is changed in place.
        self._adapters = adapters
        self._make = make
        # What each connection serves of the description that counts, by the connection's name.
        self._scopes = {scope.name: scope for scope in scopes_of(site, numbering)}

    def check_usable(self, after: Site) -> None:
        """See that this machine can speak to connections of a new kind or place.

        Raises:
            SettingsError: it cannot; nothing has changed.

        """
        # By numbers of its own: those of the new channels are given only when all is known to work.
        for scope in scopes_of(after):
            known = self._scopes.get(scope.name)
            if known is None or known.connection != scope.connection:
                # Made and let go: an adapter tells when it is made whether it can work here.
                self._make(scope)

    def redescribe(self, after: Site) -> None:
        """Serve another description; connections that stay as they were go on undisturbed."""
        of = connection_names(after)
        # First: what an adapter says from here on is of the new devices.
        self._reachability.redescribe(of)
        adapters: dict[str, tuple[Adapter, ConnectionStatus]] = {}
        scopes = {scope.name: scope for scope in scopes_of(after, self._numbering)}
        for name, scope in scopes.items():
            known = self._scopes.get(name)
            pair = self._adapters.get(name)
            # Another kind or place: the robot's side must be reached anew.
            if pair is None or known is None or known.connection != scope.connection:
                adapters[name] = self._make(scope)
            elif known == scope:
                adapters[name] = pair
            elif isinstance(pair[0], DescriptionFollower):
                # The connection to the robot stays; only what is read of it changes.
                pair[0].redescribe(scope)
                adapters[name] = pair
            else:
                adapters[name] = self._make(scope)
        # Emptied and filled, for others hold the same dictionary.
        self._adapters.clear()
        self._adapters.update(adapters)
        self._scopes = scopes
        # Last, for it begins and ends adapters by what was decided above.
        self._adapter.redescribe(of, adapters)
