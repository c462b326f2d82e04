"""The desktop program that makes a site description and starts everything.

What it knows (documents, edits, problems, what a probe or a start is doing) is plain Python;
`qt` is its outermost layer, the only one that draws and starts processes.
"""
