"""What `talaia init` and `talaia upgrade` do with a description, once their words are read."""
