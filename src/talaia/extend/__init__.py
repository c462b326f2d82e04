"""The public interface for parts that other packages bring; all else in Talaia is private.

An extension imports from here and from nowhere else of ``talaia``. What stands here stays within
one `API_VERSION`: it may get more, and nothing goes or means something else. How to write one is in
``docs/how-to/extend``.
"""

from __future__ import annotations

from talaia.extensions.declarations import API_VERSION, ExtensionKeys

__all__ = ["API_VERSION", "ExtensionKeys"]
