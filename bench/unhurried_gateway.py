"""A gateway that never hears who looks: turns of 10 ms, batches of 20 ms. For comparison.

python bench/unhurried_gateway.py gateway SITE …    as `talaia gateway SITE …`
"""

from __future__ import annotations

import sys
from functools import partial

from talaia.cli.main import main
from talaia.gateway import command_line
from talaia.gateway.adapters.ros2.rclpy_bridge import waitset
from talaia.gateway.samples.signal_watch import SignalWatch
from talaia.gateway.settings import GatewaySettings

if __name__ == "__main__":
    # As gateways were before decision 0280, which skipped the message.
    SignalWatch.subscribe = lambda _watch, _asked: None  # type: ignore[method-assign]
    # And as they were before decision 0304, whoever looks.
    waitset.PACE_S = 0.010
    command_line.GatewaySettings = partial(GatewaySettings, flush=0.020)  # type: ignore[misc,assignment]
    sys.exit(main())
