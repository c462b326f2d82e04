"""From what a probe found, or a founding command file, to a description that runs."""
