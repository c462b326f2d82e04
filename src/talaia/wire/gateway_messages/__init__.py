"""Messages between gateway and hub, by subject; import them from `wire.frames`."""
