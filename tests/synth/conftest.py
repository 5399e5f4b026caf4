"""Stand-ins for the tools."""

from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture
def native(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Put a shell script in the place of nextpnr-ecp5."""
    program = tmp_path / "nextpnr-ecp5"

    def put(script: str) -> None:
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setenv("TFRA_NEXTPNR_ECP5", str(program))

    return put
