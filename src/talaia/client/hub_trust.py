"""How the hub proves itself to a script: a pinned key, a given authority, or the system's trust.

As gateways do it (decision 10): with a fingerprint the certificate is looked at once without
telling the hub anything, compared, and from then on is the only one that TLS accepts. There is no
way to go on without.
"""

from __future__ import annotations

import hashlib
import ssl
import threading
from typing import TYPE_CHECKING

from talaia.certificate_pin import has_fingerprint, trust_only
from talaia.client.errors import BadSettings, HubNotReached, HubUntrusted

if TYPE_CHECKING:
    from talaia.client.hub_location import HubLocation

__all__ = ["CertificateTrust"]

# To look at the certificate (s).
_WAIT_S = 10.0


class CertificateTrust:
    """Makes the TLS context for a hub. Blocks; may be asked from several threads."""

    def __init__(self, hub: HubLocation) -> None:
        """Take where the hub is, and how it is known."""
        self._hub = hub
        self._lock = threading.Lock()
        # Made at the first connection, kept until `forget_certificate`.
        self._context: ssl.SSLContext | None = None

    def tls_context(self) -> ssl.SSLContext | None:
        """Give the context; none for plain text, which is for loopback.

        Raises:
            HubNotReached: nobody answers.
            HubUntrusted: another certificate is shown than the pinned one.
            BadSettings: the file of authorities cannot be used.

        """
        if self._hub.plain:
            return None
        with self._lock:
            if self._context is None:
                pinned = bool(self._hub.fingerprint)
                self._context = self._pin_certificate() if pinned else self._by_authority()
            return self._context

    def forget_certificate(self) -> None:
        """Look again next time: a renewed certificate has the same key."""
        with self._lock:
            self._context = None

    def _by_authority(self) -> ssl.SSLContext:
        try:
            return ssl.create_default_context(cafile=str(self._hub.ca) if self._hub.ca else None)
        except OSError as error:
            raise BadSettings(f"certificate authorities {self._hub.ca}: {error}") from error

    def _pin_certificate(self) -> ssl.SSLContext:
        try:
            # Nothing is verified here and nothing is sent: the certificate is only looked at.
            text = ssl.get_server_certificate((self._hub.host, self._hub.port), timeout=_WAIT_S)
        except OSError as error:
            raise HubNotReached(f"{self._hub.page} cannot be reached: {error}") from error
        shown = ssl.PEM_cert_to_DER_cert(text)
        found = hashlib.sha256(shown).hexdigest()
        if not has_fingerprint(shown, self._hub.fingerprint):
            raise HubUntrusted(
                f"{self._hub.page} shows the certificate {found}, which is not the one that is"
                f" known ({self._hub.fingerprint}); if the hub was set up anew, ask its admin for"
                " the new fingerprint, else somebody stands between"
            )
        return trust_only(shown)
