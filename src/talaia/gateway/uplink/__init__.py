"""The connection to the hub: dialling, lanes, catching up."""
