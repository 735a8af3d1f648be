"""The version, in one place."""

__version__ = "0.4.0"


def simulated_with(version: str) -> str:
    """Return `simulated with version ...` for results of another version than this one, else an empty text."""
    return "" if version == __version__ else f"simulated with version {version}"
