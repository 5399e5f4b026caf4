"""What all tests share: one hypothesis profile, and one cache of generated cores and simulators' executables."""

import gc
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# None depends on the machine's speed, and any failure can be repeated.
settings.register_profile("tfra", deadline=None, print_blob=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("tfra")


def pytest_collection_finish() -> None:
    """Modules and tests are there to stay: what collects garbage need not look at them again and again."""
    gc.freeze()
    gc.set_threshold(100_000, 20, 20)


@pytest.fixture(scope="session")
def builds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that the processes of this run have in common: the same core is built once."""
    own = tmp_path_factory.getbasetemp()
    builds = (own.parent if own.name.startswith("popen") else own) / "builds"
    builds.mkdir(exist_ok=True)
    return builds
