"""Types and fields of ROS that a description names: whether they exist, and what they can give."""
