"""The site description: pure values, read from YAML and checked; no clock, no network."""
