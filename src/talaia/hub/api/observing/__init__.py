"""Routes of proposals, requests and nights."""
