"""Connections: of pages and of clients of other tools, served by one service."""
