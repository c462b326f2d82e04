"""The node of the ROS 1 adapter, for the Python that has rospy (3.8 or later); no talaia here."""
