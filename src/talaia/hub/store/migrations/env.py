"""Run by Alembic on a connection that `Database.migrate` hands it, in one transaction."""

from __future__ import annotations

from alembic import context

from talaia.hub.store.tables import metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    render_as_batch=True,
)
with context.begin_transaction():
    context.run_migrations()
