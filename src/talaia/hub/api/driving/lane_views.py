"""The lane that a camera sees, as a person may see it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.schemas.sighting_schemas import LaneShape
from talaia.hub.auth.permissions import sees_signal
from talaia.model.derived_signals import lane_signals
from talaia.model.detection import LANE_HEADING, LANE_OFFSET, LANE_WIDTH
from talaia.objects.floor_lines import FloorMapping

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants
    from talaia.model.site import Site

__all__ = ["describe_lane"]


def describe_lane(site: Site, device_id: str, stream_id: str, grants: Grants) -> LaneShape | None:
    """Say what is drawn over a camera's picture of its lane; none where nothing tells of it."""
    camera = f"{device_id}/{stream_id}"
    told: dict[str, str] = {}
    view = site.devices[device_id].streams[stream_id].lane
    for address, lane in lane_signals(site).items():
        if lane.camera == camera and sees_signal(
            grants, site, device_id, address.partition("/")[2]
        ):
            told[lane.sees] = address
    if view is None or LANE_OFFSET not in told:
        return None
    signal = site.devices[device_id].signals[told[LANE_OFFSET].partition("/")[2]]
    mapping = FloorMapping(view.floor.picture, view.floor.metres)
    return LaneShape(
        to_picture=mapping.picture_matrix().ravel().tolist(),
        near=view.ahead[0],
        far=view.ahead[1],
        offset=told[LANE_OFFSET],
        heading=told.get(LANE_HEADING, ""),
        width=told.get(LANE_WIDTH, ""),
        max_age=signal.stale_after,
    )
