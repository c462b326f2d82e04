"""How devices are driven, as a description says it, and what must fit."""
