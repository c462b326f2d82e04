"""The policy table: a line for everything, and each line against each kind of person."""

from typing import get_args

import pytest
from fastapi.routing import APIRoute, iter_route_contexts
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.policy import (
    FROM_BROWSER,
    FROM_GATEWAY,
    ROUTES,
    SOCKETS,
    TO_BROWSER,
    TO_GATEWAY,
    Need,
    allows,
    need_of_message,
    need_of_route,
)
from talaia.model.load import load_site
from talaia.wire import browser, frames
