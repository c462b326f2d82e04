"""The rosbridge 2.0 protocol, as roslibjs and roslibpy speak it.

Its text is ``ROSBRIDGE_PROTOCOL.md`` of RobotWebTools' rosbridge_suite. Messages are JSON with
``op``; what a client subscribes to may come as CBOR instead.
"""
