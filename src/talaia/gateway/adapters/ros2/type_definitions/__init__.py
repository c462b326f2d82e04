"""Definitions of ROS 2 types: read, compared by hash, and made into decoders."""
