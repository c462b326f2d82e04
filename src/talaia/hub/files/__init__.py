"""Where whole files are kept: the data folder, or a bucket of an object store."""
