"""One file per version of the tables; each leads from the one before to its own."""
