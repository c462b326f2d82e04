"""``python -m talaia.sim.vehicle``."""

from __future__ import annotations

import sys

from talaia.sim.vehicle.run import main

sys.exit(main())
