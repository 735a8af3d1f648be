"""The version, in one place."""

__version__ = "0.4.0"


def simulated_with(version: str) -> str:
    """Say which version made what is shown, where it is another than this one; else nothing."""
    return "" if version == __version__ else f"simulated with version {version}"
