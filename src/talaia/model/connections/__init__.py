"""One module for each robot protocol: its connection, its source, and what is checked of both."""
