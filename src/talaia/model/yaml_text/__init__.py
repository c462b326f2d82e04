"""The description's YAML: read with the place of every mistake, changed, written again."""
