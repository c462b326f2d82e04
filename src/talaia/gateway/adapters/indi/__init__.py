"""INDI without sockets or clocks: bytes to events, events to state, state to devices and goals."""
