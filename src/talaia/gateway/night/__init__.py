"""The executor of a night: armed by a person, opens, runs blocks, parks, closes."""
