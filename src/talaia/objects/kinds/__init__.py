"""Models that tell of a picture something else than boxes: a contract for each kind, in a module.

Each module has a reader, which makes of a file's outputs an answer that is small and plain (it runs
beside the gateway, in `objects.child`), what reads that answer back, and what a signal tells of it.
"""
