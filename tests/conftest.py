"""Shared settings of the tests."""

import os

import matplotlib
from hypothesis import HealthCheck, settings

pytest_plugins = ["pytester"]

matplotlib.use("Agg")
settings.register_profile(
    "contactqp", deadline=None, derandomize=True, max_examples=60, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", parent=settings.get_profile("contactqp"), max_examples=1000, derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "contactqp"))
