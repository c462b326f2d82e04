"""Network cameras by ONVIF: found, signed in at, and moved."""
