"""Every study can be loaded: most are run by hand alone, and a file that has moved is missed there last."""

import importlib
import pkgutil

import bench


def test_every_module_loads() -> None:
    names = [found.name for found in pkgutil.walk_packages(bench.__path__, "bench.")]
    assert {"bench.exactness.fingerprint", "bench.parts.estimates"} <= set(names)
    for name in names:
        importlib.import_module(name)
