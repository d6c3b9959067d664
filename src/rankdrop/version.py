"""The version that results record; its one home is pyproject.toml."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

try:
    VERSION = version("rankdrop")
except PackageNotFoundError:  # the source tree on the path, nothing installed
    VERSION = "0+unknown"
__version__ = VERSION
"""Its name in the package, looked up when it is asked for: it takes a tenth of a second."""
