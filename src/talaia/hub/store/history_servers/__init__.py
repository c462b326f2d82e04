"""Which server has a site's history, and which hub writes there."""
