"""The planner in a process of its own: what it is asked, what it answers, and its keeping.

And what proposals have left, which it is asked with.
"""
