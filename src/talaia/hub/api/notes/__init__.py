"""Notes over HTTP: written, changed, searched, and taken away as a file."""
