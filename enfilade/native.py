"""The one place where Open3D is imported.

Open3D's wheel needs ``libusb-1.0.so.0``, which a bare machine lacks. The package ``libusb-package`` carries
it; loaded with global visibility before Open3D, the dynamic linker finds it already there.
"""

from __future__ import annotations

import ctypes
from functools import cache
from types import ModuleType


@cache
def open3d() -> ModuleType:
    """Return the ``open3d`` module, its native needs loaded first and its chatter turned down."""
    import libusb_package

    library = libusb_package.get_library_path()
    if library is not None:
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    import open3d as module

    module.utility.set_verbosity_level(module.utility.VerbosityLevel.Error)
    return module
