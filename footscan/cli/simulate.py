"""`footscan simulate`."""


def simulate() -> None:
    """Placeholder."""
