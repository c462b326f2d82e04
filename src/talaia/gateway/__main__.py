"""``python -m talaia.gateway``."""

from __future__ import annotations

import sys

from talaia.gateway.program import main

sys.exit(main(sys.argv[1:]))
