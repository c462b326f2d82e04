"""The hub as a rosbridge server."""
