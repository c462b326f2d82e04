"""``talaia gateway``: its words, before anything of the gateway is imported.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from talaia.gateway.command_line import parse_arguments
from talaia.program_options import print_settings
from talaia.quiet_import import quiet_imports

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Run a gateway until SIGINT or SIGTERM; 0 after a clean end, 2 if it cannot start."""
    # Whatever it makes in its folder, now or later, is its own user's alone.
    os.umask(0o077)
    # Before the arguments are parsed: these two have arguments of their own.
    if argv and argv[0] == "enrol":
        from talaia.gateway import enrolment

        return enrolment.main(argv[1:])
    if argv and argv[0] == "test-notice":
        from talaia.gateway.notices import own_notices

        return own_notices.main(argv[1:])
    arguments, sources = parse_arguments(argv)
    if arguments.show_settings:
        print_settings(sources)
        return 0
    # The gateway with all its libraries: about a second of a core.
    with quiet_imports():
        from talaia.gateway.run import run_gateway

    return run_gateway(arguments)
