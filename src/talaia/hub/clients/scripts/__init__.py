"""Driving by scripts with a token, as other tools' clients drive."""
