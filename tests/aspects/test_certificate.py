"""Certificates that an arm is cuspidal."""

from __future__ import annotations

import pytest
from reference import cuspidal

from rankdrop.aspects import change_certificate
from rankdrop.errors import OptionError


def test_a_certificate_needs_a_path() -> None:
    with pytest.raises(OptionError, match="no path to certify"):
        change_certificate(cuspidal.postures(cuspidal.wenger(), None))
