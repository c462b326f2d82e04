"""The questions of `talaia init`, in a page."""
