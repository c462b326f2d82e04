"""Raw topics as MCAP files: a ring of the last seconds, the files, and those that wait."""
