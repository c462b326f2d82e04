"""Clouds with fewer points are still clouds, as rosbags reads them."""

from __future__ import annotations

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from talaia.hub.live.taps.cloud_thinning import CLOUD_TYPE, thin_cloud

STORE = get_typestore(Stores.LATEST)
TYPES = STORE.types


@pytest.mark.parametrize("frame", ["l", "lidar", "lidars"])
def test_each_nth_point_is_left_also_of_padded_rows(frame) -> None:
    points = np.arange(40, dtype="<f4").reshape(2, 5, 4)
    rows = np.zeros((2, 90), np.uint8)
    rows[:, :80] = points.reshape(2, 20).view(np.uint8)
    names = ("x", "y", "z", "intensity")
    field = TYPES["sensor_msgs/msg/PointField"]
    cloud = TYPES[CLOUD_TYPE](
        header=TYPES["std_msgs/msg/Header"](
            stamp=TYPES["builtin_interfaces/msg/Time"](1, 2), frame_id=frame
        ),
        height=2, width=5, fields=[field(name, 4 * at, 7, 1) for at, name in enumerate(names)],
        is_bigendian=False, point_step=16, row_step=90, data=rows.reshape(-1), is_dense=True,
    )  # fmt: skip
    raw = bytes(STORE.serialize_cdr(cloud, CLOUD_TYPE))
    thin, every = thin_cloud(raw, 4)
    read = STORE.deserialize_cdr(thin, CLOUD_TYPE)
    assert (every, read.width, read.height, read.row_step, read.is_dense) == (3, 4, 1, 64, True)
    assert read.data.view("<f4").reshape(-1, 4).tolist() == points.reshape(10, 4)[::3].tolist()
    assert thin_cloud(raw, 10) == (raw, 1)
    for cut in (0, 5, 40, len(raw) - 60):
        assert thin_cloud(raw[:cut], 1) == (raw[:cut], 1)
