"""Boards as values: a grid of tiles that shows a site, or any robot of a kind."""
