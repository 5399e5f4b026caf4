"""One hypothesis profile for all tests: none depends on the machine's speed, and any failure can be repeated."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

settings.register_profile("tfra", deadline=None, print_blob=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("tfra")
