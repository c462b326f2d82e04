"""Models of the observatory's hardware: how each device behaves, without any network."""
