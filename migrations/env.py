"""How Alembic runs the revisions of a library: on the connection it is given, in silence.

There is no alembic.ini: `lanindex.library.migrate` starts it, with a connection that is already
in a transaction. A new revision is a file in ``versions/`` whose name begins with the next
number; the tests compare what it leads to with ``lanindex/library/schema.py``.
"""

from alembic import context

from lanindex.library.schema import tables

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=tables,
    render_as_batch=True,
    transactional_ddl=True,
)
context.run_migrations()
