"""Lists of targets and requests as other programs write them, read as request groups. Pure."""
