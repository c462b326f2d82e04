"""Focusing, solving, centring and guiding beside the executor of a night: the I/O of it."""
