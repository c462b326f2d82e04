"""A deployment's files, made of a site description. Values in, texts out; writes nothing."""
