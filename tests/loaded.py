"""Scripts that are no part of the package, as modules: examples and benchmarks."""

import importlib.util


def load(path):
    """The module in a file."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
