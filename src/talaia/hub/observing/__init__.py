"""Rules of proposals and requests: who may what, which state follows, what it costs. Pure."""
