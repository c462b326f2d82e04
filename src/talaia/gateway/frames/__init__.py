"""Pictures for the archive: from a camera's bytes to a file with a whole header, to the hub."""
