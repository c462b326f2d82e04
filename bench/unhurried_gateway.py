"""A gateway that does not hear who looks: its batches keep their 20 ms. For comparison.

python bench/unhurried_gateway.py gateway SITE …    as `talaia gateway SITE …`
"""

from __future__ import annotations

import sys

from talaia.cli.main import main
from talaia.gateway.samples.signal_watch import SignalWatch

if __name__ == "__main__":
    # As gateways were before decision 0280, which skipped the message.
    SignalWatch.subscribe = lambda _watch, _asked: None  # type: ignore[method-assign]
    sys.exit(main())
