"""Alembic's entry: the connection and the transaction are those of `footscan.records.migrate`."""

from alembic import context

from footscan.records.tables import Row

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Row.metadata,
    render_as_batch=True,
    transactional_ddl=True,
)
context.run_migrations()
