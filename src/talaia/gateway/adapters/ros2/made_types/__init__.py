"""Message classes for types whose Python package is not installed here."""
