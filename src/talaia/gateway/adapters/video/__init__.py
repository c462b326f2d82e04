"""Cameras without ROS: RTSP and V4L2, by PyAV."""
