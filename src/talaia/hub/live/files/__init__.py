"""Files that gateways and people hand over: recordings, FITS files, imports."""
