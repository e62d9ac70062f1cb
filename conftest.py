"""What holds for the tests of all packages."""

from __future__ import annotations

from hypothesis import settings
from hypothesis.internal.conjecture import providers

# A test fails for what was changed, not for examples that nobody has tried before.
settings.register_profile('fixed', derandomize=True, database=None, deadline=None)
settings.load_profile('fixed')

# Hypothesis also draws numbers that it finds in the source of whatever is imported by then. So a
# test with `derandomize` would still try other examples after a change elsewhere, or in another
# order of tests. Without constants of ours its examples are fixed.
assert hasattr(providers, '_get_local_constants')
providers._get_local_constants = lambda: providers._local_constants
