"""Migrations of the records, run by Alembic when a data folder is opened. Shipped ones are never edited."""
