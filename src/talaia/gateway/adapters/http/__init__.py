"""The HTTP adapter: addresses of a server, asked again and again."""
