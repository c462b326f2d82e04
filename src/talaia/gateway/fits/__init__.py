"""FITS files: headers, files from cameras, and the outbox to the hub's archive."""
