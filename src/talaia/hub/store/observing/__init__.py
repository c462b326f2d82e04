"""Proposals, requests and observations in the database."""
