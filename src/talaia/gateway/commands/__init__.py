"""One-shot commands: who may ask, where each stands, and what is written down."""
