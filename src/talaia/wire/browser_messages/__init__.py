"""Messages between hub and browser, by subject; import them from `wire.browser`."""
