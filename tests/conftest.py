"""What every test needs: JAX on the processor, and the same examples on every machine."""

import os

from hypothesis import settings

os.environ.setdefault("JAX_PLATFORMS", "cpu")

settings.register_profile("ci", deadline=None, derandomize=True, database=None)
settings.load_profile("ci")
